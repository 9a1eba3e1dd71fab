// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The in-process gauge of a machine that has one, from the machine file to the bag.

use crate::support;

use byteorder::LittleEndian;
use camwright_bag::Bag;
use camwright_msgs::camwright_msgs::msg::{GaugeReading, PartLobe};
use std::process::Command;
use support::{Domain, Folder};

/// One lobe ground under a gauge 250° behind the wheel: whatever it reads of a lobe that is nearly at size are the radii of the lobe
/// that come out of the machine at last, where they passed it, and every reading is in the bag.
#[test]
fn a_gauge_reads_the_diameters_of_what_passed_the_wheel() {
    let folder = Folder::new("gauge");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(["run", "--json", "--bag"]).arg(&bag);
    for set in [
        "lobes=[{name: I1, station: LS1, profile: intake, phase_deg: 210, width_mm: 14}]",
        "infeed.total_mm=0.072",
        "stock_mm=0.06",
    ] {
        command.args(["--set", set]);
    }
    command.args(["--set-machine", "gauge={kind: diameter, behind_wheel_deg: 250, resolution_um: 0.1, noise_um: 0}"]);
    let output = command.output().expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    let bag = Bag::open(&bag).expect("a bag");
    let (mut readings, mut part) = (Vec::<GaugeReading>::new(), PartLobe::default());
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message().expect("a readable bag") {
        // Four octets say how the rest is encoded.
        let data = &message.data[4..];
        match bag.topics()[message.topic].name.as_str() {
            "/machine/gauge" => readings.push(cdr_encoding::from_bytes::<_, LittleEndian>(data).expect("a reading").0),
            "/machine/part" => part = cdr_encoding::from_bytes::<_, LittleEndian>(data).expect("a part").0,
            _ => {}
        }
    }
    assert!(part.finished && part.name == "I1", "{} {}", part.name, part.finished);
    // Two turns with infeed and four of spark-out at one turn a second.
    assert!(readings.len() > 5500, "{} readings", readings.len());
    assert!(readings.windows(2).all(|pair| pair[0].tick < pair[1].tick));
    let n = part.radius.len() as f64;
    let radius = |azimuth: f64| {
        let steps = (azimuth / std::f64::consts::TAU).rem_euclid(1.0) * n;
        #[allow(clippy::cast_possible_truncation, reason = "an index of the outline")]
        let (index, share) = (steps as usize % part.radius.len(), steps.fract());
        part.radius[index] + share * (part.radius[(index + 1) % part.radius.len()] - part.radius[index])
    };
    let gauge_angle = 250.0_f64.to_radians();
    let mut span = (f64::INFINITY, 0.0_f64);
    for reading in &readings[readings.len() - 900..] {
        assert_eq!((reading.lobe.as_str(), reading.kind), ("I1", GaugeReading::DIAMETER));
        assert!((reading.gauge_angle - gauge_angle).abs() < 1e-12);
        let at = reading.spindle_angle - gauge_angle;
        let wanted = radius(at) + radius(at + std::f64::consts::PI);
        // What the last turn still takes on either side, and half a step.
        assert!((reading.reading - wanted).abs() < 2e-6, "{} m at {at} rad, not {wanted} m", reading.reading);
        span = (span.0.min(wanted), span.1.max(wanted));
    }
    assert!(span.1 - span.0 > 1e-3, "a cam is not round: {span:?}");
}
