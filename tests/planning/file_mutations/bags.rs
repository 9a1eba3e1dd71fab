// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bags with changed bytes, and bags that are whole but hold changed messages.

use super::mutate;
use super::random::Random;
use camwright_bag::{Bag, BagMessage, BagWriter, RecordingOutcome, Topic, WriterOptions};
use std::fs;
use std::path::Path;

/// A bag to be changed.
#[derive(Debug)]
pub struct BagSeed {
    storage: (String, Vec<u8>),
    metadata: String,
    topics: Vec<Topic>,
    messages: Vec<BagMessage>,
}

/// Bytes of the number that begins a message, of what messages hold, and of counts.
const WIDTHS: [usize; 4] = [1, 4, 8, 8];

impl BagSeed {
    pub fn read(path: &Path) -> Self {
        let bag = Bag::open(path).expect("a golden bag");
        let (mut reader, mut messages) = (bag.messages(), Vec::new());
        while let Some(message) = reader.next_message().expect("it is whole") {
            messages.push(message);
        }
        drop(reader);
        let file = &bag.files()[0].path;
        let name = file.file_name().expect("a file").to_string_lossy().into_owned();
        Self {
            storage: (name, fs::read(file).expect("a file")),
            metadata: fs::read_to_string(path.join("metadata.yaml")).expect("its metadata"),
            topics: bag.topics().to_vec(),
            messages,
        }
    }

    /// Writes a changed bag.
    pub fn mutated(&self, random: &mut Random, path: &Path) {
        let (name, bytes) = &self.storage;
        if random.below(3) > 0 && !random.is_still() {
            return self.rewritten(random, path);
        }
        fs::create_dir_all(path).expect("room");
        let is_file = random.below(2) == 0;
        let storage = if is_file { mutate::bytes(random, bytes, bytes) } else { bytes.clone() };
        let metadata = if is_file {
            self.metadata.clone().into_bytes()
        } else {
            mutate::text(random, &self.metadata, &self.metadata)
        };
        fs::write(path.join(name), storage).expect("room");
        if random.below(10) > 0 {
            fs::write(path.join("metadata.yaml"), metadata).expect("room");
        }
    }

    /// Sums and index fit, but some messages, names or definitions are others.
    fn rewritten(&self, random: &mut Random, path: &Path) {
        let mut topics = self.topics.clone();
        if random.below(4) == 0 {
            let at = random.below(topics.len());
            let topic = &mut topics[at];
            match random.below(5) {
                0 => topic.name = format!("/{}", "x".repeat(70_000)),
                1 => topic.type_name = format!("a/msg/{}", "x".repeat(70_000)),
                2 => {
                    topic.definition =
                        String::from_utf8_lossy(&mutate::text(random, &topic.definition, "float64[] x")).into_owned();
                }
                3 => topic.name = String::from("../../\u{1b}[2J/\u{0}x"),
                _ => topic.type_name = String::from("std_msgs/msg/String"),
            }
        }
        let mut writer = BagWriter::create(path, &WriterOptions::default()).expect("a new bag");
        let Ok(ids) = topics.iter().map(|topic| writer.add_topic(topic)).collect::<Result<Vec<_>, _>>() else {
            // What our own writer refuses is tried as bytes.
            drop(writer);
            let _gone = fs::remove_dir_all(path);
            fs::create_dir_all(path).expect("room");
            fs::write(path.join(&self.storage.0), mutate::bytes(random, &self.storage.1, &self.storage.1))
                .expect("room");
            return;
        };
        // Mostly few messages are changed, at times every tenth.
        let share = *random.pick(&[0.0005, 0.0005, 0.005, 0.1]);
        let of_topic = (random.below(2) == 0).then(|| random.below(topics.len()));
        let mut once = random.below(self.messages.len());
        if let Some(of_topic) = of_topic {
            let own: Vec<usize> = (0..self.messages.len()).filter(|at| self.messages[*at].topic == of_topic).collect();
            once = if own.is_empty() { once } else { *random.pick(&own) };
        }
        for (at, message) in self.messages.iter().enumerate() {
            let is_changed =
                at == once || (of_topic.is_none_or(|topic| topic == message.topic) && random.share() < share);
            let data = if is_changed { changed(random, &message.data) } else { message.data.clone() };
            if is_changed && random.below(20) == 0 {
                continue;
            }
            let later = if is_changed && random.below(10) == 0 { u64::MAX / 2 } else { 0 };
            let time = message.log_time_ns.saturating_add(later);
            writer.write(ids[message.topic], time, message.publish_time_ns, &data).expect("room");
        }
        writer.close(RecordingOutcome::Complete, 0).expect("closed");
    }
}

/// A message with numbers or lengths changed where CDR has them.
fn changed(random: &mut Random, data: &[u8]) -> Vec<u8> {
    let mut data = data.to_vec();
    if data.len() < 12 || random.below(5) == 0 {
        return mutate::bytes(random, &data, &data);
    }
    for _ in 0..1 + random.below(3) {
        let width = *random.pick(&WIDTHS);
        let at = 4 + random.below((data.len() - 4) / width) * width;
        let end = (at + width).min(data.len());
        let number = match random.below(3) {
            0 => f64::to_le_bytes(*random.pick(&[0.0, -1.0, 1e-300, 1e9, 1e300, f64::NAN, f64::INFINITY])),
            1 => u64::to_le_bytes(*random.pick(&[
                0,
                1,
                2,
                255,
                1000,
                100_000,
                1 << 31,
                1 << 33,
                1 << 62,
                u64::MAX / 2,
                u64::MAX,
            ])),
            _ => u64::to_le_bytes(1 << random.below(64)),
        };
        data[at..end].copy_from_slice(&number[..end - at]);
    }
    data
}
