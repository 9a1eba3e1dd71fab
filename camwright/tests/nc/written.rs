// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A small program on every control, and the targets of its blocks.

use super::sample::{format, target, two_cams};
use camwright::gcode::{Block, Dialect, NcAxis, Step, XValues, driven, raised_feeds};
use std::path::Path;

/// The text of each file of each dialect stands beside this one, so that people see what they get.
#[test]
fn a_small_program_is_written_as_it_stands_beside() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/nc/golden");
    for (dialect, x_values, folder) in [
        (Dialect::LinuxCnc, XValues::Radius, "linuxcnc"),
        (Dialect::LinuxCnc, XValues::Diameter, "linuxcnc_diameter"),
        (Dialect::Fanuc, XValues::Radius, "fanuc"),
        (Dialect::Siemens, XValues::Radius, "siemens"),
        (Dialect::Siemens, XValues::Diameter, "siemens_diameter"),
    ] {
        let files = dialect.write(&two_cams(x_values)).expect("it can be written");
        let mut names: Vec<_> = files.iter().map(|file| file.name.clone()).collect();
        for file in &files {
            let path = golden.join(folder).join(&file.name);
            let expected = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(file.text == expected, "{} should be\n{}", path.display(), file.text);
        }
        names.sort();
        let listed = std::fs::read_dir(golden.join(folder)).expect("a folder").flatten();
        let mut listed: Vec<_> = listed.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        listed.sort();
        assert_eq!(names, listed);
    }
}

/// `F` times the time is a minute, to a ten-millionth where the control reads so many digits.
#[test]
fn a_feed_is_a_minute_over_its_time() {
    for dialect in Dialect::ALL {
        let max_error = if dialect == Dialect::Fanuc { 0.000_5 } else { 5e-7 };
        for (index, time_s) in [0.006_5, 0.01, 0.123_456_789, 1.0, 7.0, 59.9, 119.9].into_iter().enumerate() {
            let mut program = two_cams(XValues::Radius);
            let blocks = vec![Block::Feed { target: target(&[(NcAxis::C, 1)]), time_s }];
            program.main = blocks.into_iter().map(Step::Block).collect();
            program.subprograms.clear();
            let files = dialect.write(&program).expect("it can be written");
            let line = files[0].text.lines().find(|line| line.starts_with("G1 ")).expect("a feed");
            let number = line.split(" F").nth(1).expect("its feed");
            let (whole, places) = number.split_once('.').expect("a point, or a Fanuc reads thousandths");
            assert!(!whole.is_empty() && !places.is_empty(), "{number}");
            let feed: f64 = number.parse().expect("a number");
            let min_error = 5e-8 * feed;
            let off = (feed - 60.0 / time_s).abs();
            assert!(off <= min_error || off <= max_error, "{dialect:?} {index}: {line} for {time_s} s");
        }
    }
}

/// The position after each block is the sum of the written value and the shift of the call.
#[test]
fn blocks_of_a_subprogram_are_shifted_by_its_call() {
    let program = two_cams(XValues::Radius);
    let moves = driven(&program);
    // Two rapids, seven motions, seven motions, two rapids, seven motions.
    assert_eq!(moves.len(), 25);
    let (x, c) = (NcAxis::X.index(), NcAxis::C.index());
    assert_eq!(moves[2].pose, [Some(423_000), None, Some(-205_000), Some(1_500_000)]);
    assert_eq!((moves[5].pose[x], moves[5].pose[c], moves[5].time_s), (Some(438_500), Some(3_300_000), Some(3.0)));
    assert_eq!((moves[9].pose[x], moves[9].pose[c]), (Some(420_001), Some(5_100_000)));
    assert_eq!((moves[2].call, moves[9].call, moves[18].call), (Some(0), Some(1), Some(2)));
    assert_eq!(moves[24].pose, [Some(420_000), None, Some(-400_000), Some(3_600_000 - 123_456)]);
    assert_eq!(moves[16].subprogram, None);
}

/// 0.001 mm in 0.6 s are 0.1 mm/min; a turn without X has its rate in degrees: 0.1° in 59 s are more than 0.1°/min, in 61 s less.
#[test]
fn feeds_that_linuxcnc_would_raise_are_found_in_radius_and_diameter() {
    for (x_values, written) in [(XValues::Radius, 10), (XValues::Diameter, 20)] {
        let mut program = two_cams(x_values);
        assert_eq!(raised_feeds(&program), []);
        let at = |x, c, time_s| Block::Feed { target: target(&[(NcAxis::X, x), (NcAxis::C, c)]), time_s };
        program.subprograms[0].blocks = vec![
            Block::Rapid(target(&[(NcAxis::X, 0), (NcAxis::C, 0)])),
            at(written, 1000, 0.59),
            at(0, 2000, 0.61),
            at(0, 3000, 59.0),
            at(0, 4000, 61.0),
            at(written, 5000, 0.001),
        ];
        let raised = raised_feeds(&program);
        assert_eq!(raised.len(), 2, "the subprogram is called twice: {raised:?}");
        assert!((raised[0].driven_s - 0.6).abs() < 1e-9 && (raised[0].way - 0.001).abs() < 1e-12);
        assert!((raised[1].driven_s - 60.0).abs() < 1e-9 && raised[1].unit == "deg" && raised[1].place.block == 5);
        let text = raised[0].to_string();
        assert!(text.starts_with("subprogram A, block 3: 0.001 mm in 0.61 s are 0.0983"), "{text}");
    }
}

#[test]
fn counts_are_those_of_the_text_and_back() {
    let (radius, diameter) = (format(XValues::Radius), format(XValues::Diameter));
    assert_eq!(radius.count(NcAxis::X, 12.345_67), Ok(123_457));
    assert_eq!(diameter.count(NcAxis::X, 12.345_67), Ok(246_913));
    assert_eq!(diameter.count(NcAxis::Z, 12.345_67), Ok(123_457));
    assert_eq!(radius.count(NcAxis::C, -core::f64::consts::PI), Ok(-1_800_000));
    assert_eq!(diameter.value(NcAxis::X, 246_913).to_bits(), 12.345_65_f64.to_bits());
    assert!((radius.value(NcAxis::C, -1_800_000) + core::f64::consts::PI).abs() < 1e-15);
    assert!(radius.count(NcAxis::Y, f64::NAN).is_err());
}
