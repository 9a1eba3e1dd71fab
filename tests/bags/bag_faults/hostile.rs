// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Malicious bags, and bags with some bytes changed: every command ends, says something, and takes no more
//! memory than it should.

#![allow(unreachable_pub, reason = "a module of a test binary has no outside")]

use super::draft::{Draft, PAGES, patch_last, records, without_crc};
use camwright_bag::export::{TableFormat, to_tables};
use camwright_bag::info::BagInfo;
use camwright_bag::{Bag, check, recover};
use mcap::records::op;
use std::path::Path;

/// The 80 signs between the types of a definition.
fn line() -> String {
    "=".repeat(80)
}

/// A type that uses the next one, so deep; `fields` of it in each.
fn nested(depth: usize, fields: usize) -> String {
    let mut text = String::new();
    for level in 0..depth {
        if level > 0 {
            text.push_str(&format!("\n{}\nMSG: std_msgs/T{level}\n", line()));
        }
        for field in 0..fields {
            text.push_str(&format!("T{} f{field}\n", level + 1));
        }
    }
    text + &format!("\n{}\nMSG: std_msgs/T{depth}\nint8 x\n", line())
}

fn put(bytes: &mut [u8], at: usize, number: u64) {
    bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
}

/// A good bag with one change.
fn changed(change: fn(&mut Draft)) -> Draft {
    let mut draft = Draft::good();
    draft.options = without_crc;
    change(&mut draft);
    draft
}

/// Each with what is hostile in it.
pub fn all() -> Vec<(&'static str, Draft)> {
    let lengths = |draft: &mut Draft| {
        draft.patch = |bytes| {
            let (at, _) = records(bytes, op::CHUNK)[1];
            put(bytes, at - 8, u64::MAX / 2);
        };
    };
    let chunk_of_a_terabyte = |draft: &mut Draft| {
        draft.options = |options| without_crc(options).compression(Some(mcap::Compression::Zstd));
        draft.patch = |bytes| {
            let (at, _) = records(bytes, op::CHUNK)[1];
            put(bytes, at + 16, 1 << 40);
            // The index says so too, behind times, place, length, and an empty map of three channels at most.
            for (at, length) in records(bytes, op::CHUNK_INDEX) {
                put(bytes, at + length - 8, 1 << 40);
            }
        };
    };
    let statistics = |draft: &mut Draft| {
        draft.patch = |bytes| {
            let (at, length) = records(bytes, op::STATISTICS)[0];
            // All of its numbers: messages, times, and the counts of channels.
            put(bytes, at, u64::MAX);
            put(bytes, at + 26, u64::MAX);
            put(bytes, at + 34, 1);
            for channel in 0..4 {
                put(bytes, at + length - 8 - 10 * channel, u64::MAX);
            }
        };
    };
    let index = |draft: &mut Draft| {
        draft.patch = |bytes| {
            let (at, length) = records(bytes, op::CHUNK_INDEX)[0];
            let record = bytes[at - 9..at + length].to_vec();
            let again: Vec<u8> = std::iter::repeat_n(record, 50_000).flatten().collect();
            bytes.splice(at - 9..at - 9, again);
        };
    };
    vec![
        ("a chunk of 2^63 bytes", changed(lengths)),
        ("a chunk that says it is of 1 TB", changed(chunk_of_a_terabyte)),
        ("statistics of 2^64 messages that end before they begin", changed(statistics)),
        ("an index that lists one chunk 50000 times", changed(index)),
        (
            "offsets beyond the file",
            changed(|d| {
                d.patch = |bytes| {
                    for (at, _) in records(bytes, op::CHUNK_INDEX) {
                        put(bytes, at + 16, u64::MAX - 3);
                    }
                    for (at, _) in records(bytes, op::METADATA_INDEX) {
                        put(bytes, at, u64::MAX - 3);
                    }
                }
            }),
        ),
        ("a definition of 250 types, one in the other", changed(|d| d.topics[PAGES].text = nested(250, 1).into())),
        ("a definition with 2^200 fields", changed(|d| d.topics[PAGES].text = nested(200, 2).into())),
        (
            "a definition with 2^200 fields in no byte",
            changed(|d| {
                d.topics[PAGES].text = nested(200, 2).replace("int8 x", "int8[0] x").into();
            }),
        ),
        (
            "a definition that holds itself over another",
            changed(|d| {
                d.topics[PAGES].text =
                    format!("A a\n{}\nMSG: std_msgs/A\nB[] b\n{0}\nMSG: std_msgs/B\nA[<=1] a\n", line()).into();
            }),
        ),
        (
            "2000 topics with one definition of 200 kB",
            changed(|d| {
                let text = (0..10_000).map(|n| format!("float64 field_number{n}\n")).collect::<String>();
                let mut like = Draft::good().topics.swap_remove(PAGES);
                (like.type_name, like.text) = ("a/msg/Wide".into(), text.into());
                for number in 0..2000 {
                    d.topics.push(like.named(&format!("/t{number}")));
                }
            }),
        ),
        ("sequences of 2^32 elements", changed(|d| d.first(PAGES).data[4..8].fill(0xff))),
        (
            "numbers of messages that jump to and fro",
            changed(|d| {
                for (place, message) in d.messages().iter_mut().enumerate() {
                    message.sequence = if place % 2 == 0 { u32::MAX - u32::try_from(place).expect("few") } else { 1 };
                }
            }),
        ),
        (
            "metadata.yaml that lists a file 20000 times",
            changed(|d| {
                d.account = |m| {
                    m.relative_file_paths = vec!["run_0.mcap".into(); 20_000];
                    m.files = vec![m.files[0].clone(); 20_000];
                };
            }),
        ),
        (
            "metadata.yaml with 2^64 messages",
            changed(|d| {
                d.account = |m| {
                    m.files[0].message_count = u64::MAX;
                    m.topics.iter_mut().for_each(|topic| topic.message_count = u64::MAX);
                    (m.duration_ns, m.starting_time_ns) = (u64::MAX, u64::MAX);
                    (m.files[0].duration_ns, m.files[0].starting_time_ns) = (u64::MAX, u64::MAX);
                };
            }),
        ),
        ("metadata.yaml nested 100000 deep", changed(|d| d.yaml = |_| "[".repeat(100_000))),
        (
            "metadata.yaml whose aliases multiply",
            changed(|d| {
                d.yaml = |_| {
                    let mut text = String::from("a0: &a0 [x, x]\n");
                    for n in 1..60 {
                        text.push_str(&format!("a{n}: &a{n} [*a{0}, *a{0}]\n", n - 1));
                    }
                    text
                };
            }),
        ),
        (
            "a file that is a pipe",
            changed(|d| {
                d.directory = |bag| {
                    std::fs::remove_file(bag.join("run_0.mcap")).expect("it is there");
                    let made = std::process::Command::new("mkfifo").arg(bag.join("run_0.mcap")).status();
                    assert!(made.is_ok_and(|status| status.success()), "there is mkfifo");
                };
            }),
        ),
        (
            "times at the end of time",
            changed(|d| {
                for (place, message) in (0..).zip(d.messages().iter_mut()) {
                    message.log_time_ns = if place == 0 { 1 } else { u64::MAX - 100 + place };
                }
            }),
        ),
        (
            "what looks like a chunk everywhere",
            changed(|d| {
                d.patch = |bytes| {
                    let mut fake = vec![op::CHUNK];
                    fake.extend(1_000_000_u64.to_le_bytes());
                    fake.resize(60, 0);
                    *bytes = std::iter::repeat_n(fake, 50_000).flatten().collect();
                };
            }),
        ),
        ("an index of metadata that is none", changed(|d| d.patch = |bytes| patch_last(bytes, op::METADATA_INDEX, 9))),
    ]
}

/// Numbers that look random and are the same every time (xorshift64*).
pub struct Seeded(u64);

impl Seeded {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let number = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33;
        usize::try_from(number).expect("31 bits") % bound.max(1)
    }
}

/// Changes some bytes.
pub fn mutate(bytes: &mut Vec<u8>, random: &mut Seeded) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(7) {
            0 | 1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at] = [0, 1, 0x7f, 0xff][random.below(4)],
            3 => {
                let extreme = [0, 1, u64::MAX, u64::MAX / 2, 1 << 32, u64::from(u32::MAX)][random.below(6)];
                let end = (at + 8).min(bytes.len());
                bytes[at..end].copy_from_slice(&extreme.to_le_bytes()[..end - at]);
            }
            4 => bytes.truncate(at.max(1)),
            5 => {
                let end = (at + random.below(200)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            _ => drop(bytes.drain(at..(at + 1 + random.below(40)).min(bytes.len() - 1).max(at))),
        }
    }
}

/// Everything that reads a bag, on this one; what each says does not matter.
pub fn read_in_every_way(directory: &Path) {
    let bag = directory.join("run");
    let is_sound = check::check(&bag).is_ok_and(|report| report.worst().is_none());
    drop(BagInfo::read(&bag));
    drop(recover::recover(&bag, &directory.join("recovered")));
    drop(camwright_analysis::report::write(&bag, Some(&directory.join("report.html")), None));
    drop(camwright_analysis::rerun::rerun(&bag));
    let Ok(read) = Bag::open(&bag) else {
        assert!(!is_sound, "the check found nothing, and the bag cannot be opened");
        return;
    };
    let mut messages = read.messages();
    while let Ok(Some(_)) = messages.next_message() {}
    drop(to_tables(&read, &directory.join("csv"), TableFormat::Csv, 64));
    drop(to_tables(&read, &directory.join("parquet"), TableFormat::Parquet, 4));
}
