// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Every fault that a bag can have: how it is made, and what `camwright bag check` says of it.

#![allow(missing_debug_implementations, reason = "as above")]
#![allow(unreachable_pub, reason = "a module of a test binary has no outside")]

use super::draft::{
    Draft, INPUTS, JOINTS, PAGES, STATUS, cdr, find, footer_at, message_with, patch_last, records, without_crc,
};
use camwright_bag::check::BagSeverity;
use camwright_msgs::camwright_msgs::msg::RecorderStatus;
use mcap::records::op;
use std::path::Path;

pub struct Fault {
    pub what: &'static str,
    pub make: fn() -> Draft,
    pub severity: BagSeverity,
    /// Location of the finding, and a part of its sentence.
    pub place: &'static str,
    pub text: &'static str,
}

/// A good bag with one change.
macro_rules! broken {
    ($what:literal, $severity:ident, $place:literal, $text:literal, $change:expr) => {
        Fault {
            what: $what,
            make: || {
                let mut draft = Draft::good();
                let change: fn(&mut Draft) = $change;
                change(&mut draft);
                draft
            },
            severity: BagSeverity::$severity,
            place: $place,
            text: $text,
        }
    };
}

fn zstd(options: mcap::WriteOptions) -> mcap::WriteOptions {
    options.compression(Some(mcap::Compression::Zstd))
}

fn fastwrite(options: mcap::WriteOptions) -> mcap::WriteOptions {
    options.use_chunks(false).emit_message_indexes(false)
}

fn no_summary(options: mcap::WriteOptions) -> mcap::WriteOptions {
    options.emit_summary_records(false).emit_summary_offsets(false)
}

fn flip_page(bytes: &mut [u8]) {
    let at = find(bytes, b"page 1");
    bytes[at] ^= 1;
}

fn rename(bag: &Path) {
    std::fs::rename(bag.join("run_0.mcap"), bag.join("other.mcap")).expect("it is there");
}

pub fn all() -> Vec<Fault> {
    [bytes(), layout(), accounts(), types(), messages(), runs()].into_iter().flatten().collect()
}

/// Bytes that are not those that were written.
fn bytes() -> Vec<Fault> {
    vec![
        broken!("a byte of a message flipped", Error, "run_0.mcap", "CRC failed", |d| d.patch =
            |bytes| flip_page(bytes)),
        broken!("a byte of a compressed chunk flipped", Error, "run_0.mcap", "not readable beyond this", |d| {
            d.options = zstd;
            d.patch = |bytes| {
                let (at, length) = records(bytes, op::CHUNK)[1];
                bytes[at + length - 20] ^= 1;
            };
        }),
        broken!("check sum of a chunk wrong", Error, "run_0.mcap", "CRC failed", |d| {
            d.patch = |bytes| {
                let (at, _) = records(bytes, op::CHUNK)[0];
                bytes[at + 24] ^= 1;
            };
        }),
        broken!("check sum of the data section wrong", Error, "run_0.mcap", "CRC failed", |d| {
            d.patch = |bytes| patch_last(bytes, op::DATA_END, 0);
        }),
        broken!("check sum of the summary wrong", Error, "run_0.mcap", "CRC failed", |d| {
            d.patch = |bytes| patch_last(bytes, op::FOOTER, 16);
        }),
        broken!("tail torn off within a record", Error, "run_0.mcap", "the recording was killed", |d| {
            d.patch = |bytes| bytes.truncate(bytes.len() * 2 / 3);
        }),
        broken!("footer missing", Error, "run_0.mcap", "the recording was killed", |d| {
            d.patch = |bytes| bytes.truncate(footer_at(bytes));
        }),
        broken!("bytes behind the end", Error, "run_0.mcap", "there are bytes behind its end", |d| {
            d.patch = |bytes| bytes.extend([0; 16]);
        }),
        broken!("first bytes not those of MCAP", Error, "run_0.mcap", "not readable beyond this", |d| {
            d.patch = |bytes| bytes[0] = b'x';
        }),
    ]
}

/// Records that are whole, and lead nowhere.
fn layout() -> Vec<Fault> {
    vec![
        broken!("no summary", Warning, "run_0.mcap", "it has no summary", |d| d.options = no_summary),
        broken!("no statistics", Warning, "run_0.mcap", "its summary has no statistics", |d| {
            d.options = |options| options.emit_statistics(false);
        }),
        broken!("no index of chunks", Warning, "run_0.mcap", "there is no index of chunks", |d| {
            d.options = |options| options.emit_chunk_indexes(false);
        }),
        broken!("no index of messages", Error, "run_0.mcap", "its chunks have no message index", |d| {
            d.options = |options| options.emit_message_indexes(false);
        }),
        broken!("no chunks (fastwrite)", Warning, "run_0.mcap", "messages stand outside of chunks", |d| {
            d.options = fastwrite;
        }),
        broken!("index of a chunk leads elsewhere", Error, "run_0.mcap", "1 index entry of a chunk is wrong", |d| {
            d.options = without_crc;
            d.patch = |bytes| patch_last(bytes, op::CHUNK_INDEX, 16);
        }),
        broken!("index of a chunk has other log times", Error, "run_0.mcap", "its log times are others", |d| {
            d.options = without_crc;
            d.patch = |bytes| patch_last(bytes, op::CHUNK_INDEX, 0);
        }),
        broken!(
            "index of messages leads elsewhere",
            Error,
            "run_0.mcap",
            "1 message index leads to other messages",
            |d| {
                d.options = without_crc;
                // Behind channel and length come a log time and an offset.
                d.patch = |bytes| patch_last(bytes, op::MESSAGE_INDEX, 2 + 4 + 8);
            }
        ),
        broken!("index of metadata leads elsewhere", Error, "run_0.mcap", "the index of metadata", |d| {
            d.options = without_crc;
            d.patch = |bytes| patch_last(bytes, op::METADATA_INDEX, 0);
        }),
        broken!("footer leads elsewhere", Error, "run_0.mcap", "summary offset start in the footer is", |d| {
            d.options = without_crc;
            d.patch = |bytes| patch_last(bytes, op::FOOTER, 8);
        }),
        broken!("offset within the summary wrong", Error, "run_0.mcap", "1 offset of the summary leads nowhere", |d| {
            d.options = without_crc;
            d.patch = |bytes| patch_last(bytes, op::SUMMARY_OFFSET, 1);
        }),
        broken!(
            "statistics: messages wrong",
            Error,
            "run_0.mcap",
            "statistics say 71 messages, the file has 70",
            |d| {
                d.options = without_crc;
                d.patch = |bytes| patch_last(bytes, op::STATISTICS, 0);
            }
        ),
        broken!(
            "statistics: messages of a topic wrong",
            Error,
            "run_0.mcap",
            "topic /run_logger/status: statistics say",
            |d| {
                d.options = without_crc;
                d.patch = |bytes| {
                    let (at, length) = records(bytes, op::STATISTICS)[0];
                    bytes[at + length - 8] ^= 1;
                };
            }
        ),
        broken!("statistics: first log time wrong", Error, "run_0.mcap", "ns as the first log time", |d| {
            d.options = without_crc;
            d.patch = |bytes| patch_last(bytes, op::STATISTICS, 8 + 2 + 4 + 4 + 4 + 4);
        }),
        broken!("opening record missing", Warning, "run_0.mcap", "no rosbag2 metadata record stands before", |d| {
            d.opening = false;
        }),
        broken!(
            "closing record missing",
            Warning,
            "run_0.mcap",
            "the rosbag2 metadata record of its end is missing",
            |d| {
                d.closing = false;
            }
        ),
        broken!("both records missing", Warning, "run_0.mcap", "there is no rosbag2 metadata record", |d| {
            (d.opening, d.closing) = (false, false);
        }),
        broken!("profile not ros2", Error, "run_0.mcap", "profile 'ros1' is not ros2", |d| d.profile = "ros1".into()),
    ]
}

/// Faults of `metadata.yaml` and of the files beside it.
fn accounts() -> Vec<Fault> {
    vec![
        broken!("metadata.yaml missing", Error, "metadata.yaml", "has no metadata.yaml", |d| {
            d.directory = |bag| std::fs::remove_file(bag.join("metadata.yaml")).expect("it is there");
        }),
        broken!("metadata.yaml is no YAML", Error, "metadata.yaml", "metadata.yaml:", |d| {
            d.yaml = |text| text.replace("duration:", "duration");
        }),
        broken!("a key missing", Error, "metadata.yaml", "ros_distro", |d| {
            d.yaml = |text| text.replace("  ros_distro: jazzy\n", "");
        }),
        broken!("files missing in it", Error, "metadata.yaml", "requires the key files", |d| {
            d.yaml = |text| text.replace("  files:\n", "  other:\n");
        }),
        broken!("of a newer version", Error, "metadata.yaml", "version 10 is newer", |d| d.account =
            |m| m.version = 10),
        broken!("of an older version", Warning, "metadata.yaml", "version 8 is older", |d| d.account =
            |m| m.version = 8),
        broken!("another storage", Error, "metadata.yaml", "storage 'sqlite3' is not mcap", |d| {
            d.account = |m| m.storage_identifier = "sqlite3".into();
        }),
        broken!("count of all messages wrong", Error, "metadata.yaml", "message_count is 71, the files have 70", |d| {
            d.account = |m| m.message_count += 1;
        }),
        broken!("count of a topic wrong", Error, "metadata.yaml", "topic /joint_states has 61 messages", |d| {
            d.account = |m| m.topics[JOINTS].message_count += 1;
        }),
        broken!("count of a file wrong", Error, "metadata.yaml", "message_count of file run_0.mcap is 71", |d| {
            d.account = |m| m.files[0].message_count += 1;
        }),
        broken!("starting time wrong", Error, "metadata.yaml", "starts at", |d| d.account =
            |m| m.starting_time_ns -= 1),
        broken!("duration wrong", Error, "metadata.yaml", "starts at", |d| d.account = |m| m.duration_ns += 1),
        broken!("duration of a file wrong", Error, "metadata.yaml", "duration of file run_0.mcap is", |d| {
            d.account = |m| m.files[0].duration_ns += 1;
        }),
        broken!("topic not listed", Error, "metadata.yaml", "topic /plan_pages of the files is not listed", |d| {
            d.account = |m| drop(m.topics.remove(PAGES));
        }),
        broken!("topic listed that is not there", Error, "metadata.yaml", "topic /ghost is not in the files", |d| {
            d.account = |m| m.topics[PAGES].name = "/ghost".into();
        }),
        broken!("type of a topic wrong", Error, "metadata.yaml", "type or hash is not that of the file", |d| {
            d.account = |m| m.topics[PAGES].type_name = "std_msgs/msg/Bool".into();
        }),
        broken!(
            "custom data not those of the file",
            Warning,
            "metadata.yaml",
            "differs from the metadata record",
            |d| {
                d.account = |m| drop(m.custom_data.insert("camwright.run_id".into(), "other".into()));
            }
        ),
        broken!("file missing", Error, "run_0.mcap", "cannot open", |d| {
            d.directory = |bag| std::fs::remove_file(bag.join("run_0.mcap")).expect("it is there");
        }),
        broken!("file too many", Error, "metadata.yaml", "it does not list run_1.mcap", |d| {
            d.directory = |bag| assert!(std::fs::copy(bag.join("run_0.mcap"), bag.join("run_1.mcap")).is_ok());
        }),
        broken!("file of another name", Error, "metadata.yaml", "it does not list other.mcap", |d| d.directory =
            rename),
        broken!("path leads out of the bag", Error, "metadata.yaml", "does not lie in the bag's directory", |d| {
            d.account = |m| m.relative_file_paths[0] = "../run/run_0.mcap".into();
        }),
        broken!("relative_file_paths and files disagree", Error, "metadata.yaml", "do not list the same files", |d| {
            d.account = |m| m.files[0].path = "./run_0.mcap".into();
        }),
    ]
}

/// Types and topics.
fn types() -> Vec<Fault> {
    vec![
        broken!(
            "definition not that of its hash",
            Error,
            "run_0.mcap",
            "is not the one that its type hash stands for",
            |d| {
                d.topics[PAGES].text = "string data\nint32 more\n".into();
            }
        ),
        broken!(
            "hash not that of its definition",
            Error,
            "run_0.mcap",
            "is not that of the recorded definition text",
            |d| {
                d.topics[PAGES].metadata.insert("topic_type_hash".into(), format!("RIHS01_{}", "0".repeat(64)));
            }
        ),
        broken!("hash of another form", Warning, "run_0.mcap", "type hash 'md5' is not RIHS01_", |d| {
            d.topics[PAGES].metadata.insert("topic_type_hash".into(), "md5".into());
        }),
        broken!("type name without /msg/", Error, "run_0.mcap", "is not of the form package/msg/Type", |d| {
            d.topics[PAGES].type_name = "std_msgs/String".into();
        }),
        broken!("definition not ros2msg", Error, "run_0.mcap", "definition encoding 'ros2idl' is not ros2msg", |d| {
            d.topics[PAGES].encoding = "ros2idl".into();
        }),
        broken!(
            "definition that uses an unknown type",
            Error,
            "run_0.mcap",
            "the type std_msgs/Riddle is not defined",
            |d| {
                d.topics[PAGES].text = "Riddle r\n".into();
            }
        ),
        broken!("definition that holds itself", Error, "run_0.mcap", "a type holds itself", |d| {
            d.topics[PAGES].text = "std_msgs/String[] more\n".into();
        }),
        broken!("channel without QoS", Error, "run_0.mcap", "metadata keys are not offered_qos_profiles", |d| {
            d.topics[PAGES].metadata.remove("offered_qos_profiles");
        }),
        broken!("QoS as numbers, as before version 9", Error, "run_0.mcap", "its QoS profiles are numbers", |d| {
            let text = d.topics[PAGES].metadata.get_mut("offered_qos_profiles").expect("it has some");
            *text = text
                .replace("history: unknown", "history: 3")
                .replace("reliability: reliable", "reliability: 1")
                .replace("durability: transient_local", "durability: 1")
                .replace("liveliness: automatic", "liveliness: 1");
        }),
        broken!("QoS that is no YAML", Error, "run_0.mcap", "topic /plan_pages: QoS profiles", |d| {
            d.topics[PAGES].metadata.insert("offered_qos_profiles".into(), "- history: [".into());
        }),
        broken!("message encoding not cdr", Error, "run_0.mcap", "message encoding 'json' is not cdr", |d| {
            d.topics[PAGES].message_encoding = "json".into();
        }),
        broken!("two channels of a topic", Error, "run_0.mcap", "topic /joint_states has more than one channel", |d| {
            let mut second = Draft::good().topics.swap_remove(JOINTS);
            // As of two publishers.
            let offer = second.metadata["offered_qos_profiles"].clone();
            second.metadata.insert("offered_qos_profiles".into(), format!("{offer}\n{offer}"));
            d.topics.push(second);
            let second = d.topics.len() - 1;
            d.messages().iter_mut().filter(|m| m.topic == JOINTS && m.sequence > 30).for_each(|m| m.topic = second);
        }),
        broken!("message of no channel", Error, "run_0.mcap", "1 messages belong to 1 unknown channels", |d| {
            d.options = without_crc;
            d.patch = |bytes| {
                let at = message_with(bytes, "page 1");
                bytes[at - 22] = 99;
            };
        }),
    ]
}

/// Messages: what is in them, when, and in what order.
fn messages() -> Vec<Fault> {
    vec![
        broken!(
            "message too short",
            Error,
            "run_0.mcap",
            "topic /joint_states: 1 message that their definition does not decode",
            |d| {
                let data = &mut d.first(JOINTS).data;
                data.truncate(data.len() - 8);
            }
        ),
        broken!("message too long", Error, "run_0.mcap", "8 bytes are left behind its last field", |d| {
            d.first(JOINTS).data.extend([0; 8]);
        }),
        broken!("message without the four bytes of CDR", Error, "run_0.mcap", "is not plain CDR", |d| {
            d.first(JOINTS).data[..2].copy_from_slice(&[9, 9]);
        }),
        broken!("bool that is 2", Error, "run_0.mcap", "recording: 2 is neither true nor false", |d| {
            // Behind the four bytes of CDR and a time.
            d.first(STATUS).data[4 + 8] = 2;
        }),
        broken!("text without its zero", Error, "run_0.mcap", "a text without the zero at its end", |d| {
            let data = &mut d.first(PAGES).data;
            let zero = data.iter().rposition(|byte| *byte == b'0').expect("page 0") + 1;
            data[zero] = b'x';
        }),
        broken!("text that is not UTF-8", Error, "run_0.mcap", "a text that is not UTF-8", |d| d.first(PAGES).data
            [8] = 0xff),
        broken!("length that no message can have", Error, "run_0.mcap", "elements are announced", |d| {
            let data = &mut d.first(JOINTS).data;
            let count = find(data, &2_u32.to_le_bytes());
            data[count..count + 4].fill(0xff);
        }),
        broken!("log time 0", Error, "messages", "1 message with the log time 0", |d| d.messages()[0].log_time_ns = 0),
        broken!("log time before the one before", Warning, "messages", "1 message with a log time before", |d| {
            d.messages()[5].log_time_ns -= 1_500_000;
        }),
        broken!("equal log times", Warning, "messages", "1 message with the log time of the one before", |d| {
            d.messages()[5].log_time_ns -= 1_000_000;
        }),
        broken!(
            "message lost",
            Error,
            "run_0.mcap",
            "topic /joint_states: 1 messages are missing by their numbers",
            |d| {
                d.messages().remove(10);
                d.messages().iter_mut().filter(|m| m.topic == STATUS).for_each(|m| {
                    m.data = cdr(&RecorderStatus { written: 68, ..RecorderStatus::default() });
                });
            }
        ),
        broken!("message twice", Warning, "run_0.mcap", "have a number that was there before", |d| {
            let mut again = d.messages()[68].clone();
            again.log_time_ns += 1;
            d.messages().insert(69, again);
        }),
    ]
}

/// Faults of the recorder's status.
fn runs() -> Vec<Fault> {
    let mut all = vec![
        broken!(
            "messages were lost while recording",
            Warning,
            "custom_data",
            "3 messages were received and are not in the bag",
            |d| {
                d.custom_data.insert("camwright.lost_total".into(), "3".into());
            }
        ),
        broken!("lost_total is no number", Error, "custom_data", "camwright.lost_total 'some' is no number", |d| {
            d.custom_data.insert("camwright.lost_total".into(), "some".into());
        }),
        broken!("lost_total less than the recorder counted", Error, "custom_data", "reports 2 lost messages", |d| {
            let (bag, dropped) = ("run".into(), 2);
            d.first(STATUS).data = cdr(&RecorderStatus { bag, dropped, ..RecorderStatus::default() });
        }),
        broken!("fewer messages than the recorder counted", Error, "custom_data", "reports 90 messages written", |d| {
            let (bag, written) = ("run".into(), 90);
            d.first(STATUS).data = cdr(&RecorderStatus { bag, written, ..RecorderStatus::default() });
        }),
        broken!("recording ended by a fault", Warning, "custom_data", "the recording ended early: disk", |d| {
            d.custom_data.insert("camwright.outcome".into(), "fault".into());
            d.custom_data.insert("camwright.fault".into(), "disk".into());
        }),
        broken!("recording not closed", Warning, "custom_data", "is still marked as open", |d| {
            d.custom_data.insert("camwright.outcome".into(), "open".into());
        }),
        broken!(
            "input missing by its own number",
            Error,
            "run_0.mcap",
            "inputs 3 to 3 before tick 40 are missing",
            |d| {
                let place =
                    d.messages().iter().position(|m| m.topic == INPUTS && m.sequence == 4).expect("it is there");
                d.messages().remove(place);
                // The recorder has numbered what it got.
                d.messages().iter_mut().filter(|m| m.topic == INPUTS && m.sequence > 4).for_each(|m| m.sequence -= 1);
                d.messages().iter_mut().filter(|m| m.topic == STATUS).for_each(|m| {
                    m.data = cdr(&RecorderStatus { written: 68, ..RecorderStatus::default() });
                });
            }
        ),
    ];
    let two = |what, place, text, make| Fault { what, make, severity: BagSeverity::Error, place, text };
    all.push(two("second file without what is latched", "run_1.mcap", "topic /plan_pages is latched, and", || {
        let mut draft = Draft::in_two_files();
        draft.files[1].retain(|m| m.topic != PAGES || m.sequence > 2);
        draft.custom_data.insert("camwright.repeated_total".into(), "0".into());
        draft
    }));
    all.push(two(
        "fewer repetitions than recorded",
        "custom_data",
        "are to stand at the head of a later file once more",
        || {
            let mut draft = Draft::in_two_files();
            draft.custom_data.insert("camwright.repeated_total".into(), "5".into());
            draft
        },
    ));
    all
}
