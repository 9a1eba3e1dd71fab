// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables and compressed copies.

use super::*;
use crate::export::{TableFormat, to_bag, to_tables};

#[test]
fn a_table_has_a_line_for_each_message_and_a_column_for_each_value() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let mut writer = BagWriter::create(&path, &WriterOptions::default()).expect("the directory is free");
    let texts = writer.add_topic(&topic("/cell/texts", "std_msgs/msg/String")).expect("it is open");
    let points = writer.add_topic(&topic("/point", "geometry_msgs/msg/PointStamped")).expect("it is open");
    let riddle = Topic { definition: "Unknown u\n".into(), ..topic("/riddle", "std_msgs/msg/String") };
    let riddle = writer.add_topic(&Topic { type_name: "a/msg/Riddle".into(), ..riddle }).expect("it is open");
    let torn = writer.add_topic(&topic("/torn", "std_msgs/msg/String")).expect("it is open");
    for (time, text) in [(1, "plain"), (2, "a, \"b\"\nc")] {
        writer.write(texts, time, time, &string_cdr(text)).expect("it is open");
    }
    let point = [
        &[0, 1, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 2, 0, 0, 0, b'f', 0, 0, 0][..],
        &0.1_f64.to_le_bytes(),
        &f64::MAX.to_le_bytes(),
        &(-0.0_f64).to_le_bytes(),
    ]
    .concat();
    writer.write(points, 3, 4, &point).expect("it is open");
    writer.write(riddle, 5, 5, &string_cdr("x")).expect("it is open");
    writer.write(torn, 6, 6, &[0, 1, 0, 0, 9, 0, 0, 0]).expect("it is open");
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    let into = dir.path().join("csv");
    let bag = Bag::open(&path).expect("it was closed");
    let exported = to_tables(&bag, &into, TableFormat::Csv, 64).expect("there is room");
    let reason =
        |topic: &str| exported.left_out.iter().find(|(name, _)| name == topic).map(|(_, reason)| reason.as_str());
    assert_eq!(reason("/riddle"), Some("the type a/Unknown is not defined"));
    assert_eq!(reason("/torn"), Some("message 1: data: the message ends after 4 bytes"));
    assert_eq!((exported.messages, exported.paths.len()), (3, 2));
    let read = |name: &str| std::fs::read_to_string(into.join(name)).expect("it is there");
    assert_eq!(read("cell.texts.csv"), "log_time_ns,publish_time_ns,data\r\n1,1,plain\r\n2,2,\"a, \"\"b\"\"\nc\"\r\n");
    let table = read("point.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "log_time_ns,publish_time_ns,header.stamp.sec,header.stamp.nanosec,header.frame_id,point.x,point.y,point.z"
    );
    let values: Vec<&str> = lines[1].split(',').collect();
    assert_eq!(values[..6], ["3", "4", "5", "6", "f", "0.1"]);
    assert_eq!(values[6].parse::<f64>().map(f64::to_bits), Ok(f64::MAX.to_bits()));
    assert_eq!(values[7].parse::<f64>().map(f64::to_bits), Ok((-0.0_f64).to_bits()));
    let error = to_tables(&bag, &into, TableFormat::Csv, 64).expect_err("it is there");
    assert!(matches!(error, BagError::Exists { .. }), "{error}");
}

#[test]
fn a_compressed_copy_is_the_same_bag_in_less_room() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    write_bag(&path, Preset::Default, 20_000);
    let bag = Bag::open(&path).expect("it was closed");
    let mut sizes = vec![bag.files()[0].bytes];
    for preset in [Preset::ZstdFast, Preset::Zstd, Preset::ZstdSmall] {
        let into = dir.path().join(preset.name());
        let exported = to_bag(&bag, &into, preset).expect("there is room");
        assert_eq!(exported.messages, 20_000);
        let copy = Bag::open(&into).expect("it was closed");
        assert_eq!(
            (read_all(&copy), copy.topics(), copy.custom_data()),
            (read_all(&bag), bag.topics(), bag.custom_data())
        );
        assert_eq!(check(&into).expect("there is a bag").findings, []);
        sizes.push(copy.files()[0].bytes);
    }
    assert!(sizes[2] * 2 < sizes[0], "{sizes:?}");
    assert!(sizes.windows(2).all(|pair| pair[1] < pair[0]), "the more work the smaller: {sizes:?}");
}
