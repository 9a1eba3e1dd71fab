// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A bag, and bags that differ from it in some messages.
#![allow(dead_code, reason = "each test target uses its part")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use camwright_bag::{Bag, BagMessage, BagWriter, RecordingOutcome, WriterOptions};
use camwright_files::convert::keyframes::{PartialKeyframe, pages};
use camwright_msgs::camwright_msgs::msg::MachineKeyframe;
use camwright_msgs::cdr::{message_from_sample, sample_from_message};
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// A bag with all its messages, and where others are made of it.
#[derive(Debug)]
pub struct Original {
    pub bag: Bag,
    pub all: Vec<BagMessage>,
    pub changed: PathBuf,
}

/// A message as it was.
pub fn as_it_was(message: &BagMessage) -> Option<Cow<'_, [u8]>> {
    Some(Cow::Borrowed(&message.data[..]))
}

impl Original {
    pub fn read(path: &Path, changed: PathBuf) -> Self {
        let bag = Bag::open(path).expect("a bag");
        let (mut reader, mut all) = (bag.messages(), Vec::new());
        while let Some(message) = reader.next_message().expect("the bag is readable") {
            all.push(message);
        }
        drop(reader);
        Self { bag, all, changed }
    }

    /// Positions of the messages of a type.
    pub fn places<M: camwright_msgs::Message>(&self) -> Vec<usize> {
        let is_of = |message: &BagMessage| self.bag.topics()[message.topic].type_name == M::TYPE_NAME;
        self.all.iter().enumerate().filter(|(_, message)| is_of(message)).map(|(place, _)| place).collect()
    }

    pub fn decoded<M: DeserializeOwned>(&self, place: usize) -> M {
        message_from_sample(&self.all[place].data).expect("a message of its type")
    }

    /// The bag again: what a message holds now, or nothing where it is omitted.
    pub fn rewritten<'a>(&'a self, change: impl Fn(usize, &'a BagMessage) -> Option<Cow<'a, [u8]>>) -> &'a Path {
        let _not_there = std::fs::remove_dir_all(&self.changed);
        let mut writer = BagWriter::create(&self.changed, &WriterOptions::default()).expect("a new bag");
        let topics = self.bag.topics().iter();
        let ids: Vec<_> = topics.map(|topic| writer.add_topic(topic).expect("a topic")).collect();
        for (index, message) in self.all.iter().enumerate() {
            if let Some(data) = change(index, message) {
                writer.write(ids[message.topic], message.log_time_ns, message.publish_time_ns, &data).expect("room");
            }
        }
        writer.close(RecordingOutcome::Complete, 0).expect("closed");
        &self.changed
    }

    /// Its keyframes, without their states.
    pub fn keyframes(&self) -> Vec<MachineKeyframe> {
        let mut arriving = PartialKeyframe::default();
        let of_keyframes = self.places::<MachineKeyframe>();
        of_keyframes.into_iter().filter_map(|place| arriving.add(&self.decoded(place))).collect()
    }

    /// Positions of the pages of a keyframe.
    fn pages(&self, head: &MachineKeyframe) -> Vec<usize> {
        let is_of = |place: &usize| self.decoded::<MachineKeyframe>(*place).tick == head.tick;
        self.places::<MachineKeyframe>().into_iter().filter(is_of).collect()
    }

    /// The state of a keyframe.
    pub fn state(&self, head: &MachineKeyframe) -> Vec<u8> {
        self.pages(head).into_iter().flat_map(|place| self.decoded::<MachineKeyframe>(place).data).collect()
    }

    /// With another state of about the same length in a keyframe, whose check fits it or not.
    pub fn with_state(&self, head: &MachineKeyframe, state: &[u8], fits: bool) -> &Path {
        let own = self.pages(head);
        let changed: Vec<Vec<u8>> = pages(MachineKeyframe { data: Vec::new(), ..head.clone() }, state)
            .map(|page| MachineKeyframe { check: if fits { page.check } else { head.check }, ..page })
            .map(|page| sample_from_message(&page).expect("it travels"))
            .collect();
        assert_eq!(changed.len(), own.len(), "as many pages");
        self.rewritten(|index, message| match own.binary_search(&index) {
            Ok(page) => Some(Cow::Owned(changed[page].clone())),
            Err(_) => as_it_was(message),
        })
    }
}
