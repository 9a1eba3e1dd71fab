// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which faults a campaign strikes, and when.

use crate::machine::description::{Axis, MachineDescription};
use crate::machine::setpoint::Input;
use crate::math::units::rad_from_deg;
use crate::simulation::fault::{Fault, GaugeFault};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// A fault of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultCase {
    pub name: String,
    pub fault: Fault,
    /// Injection that removes the fault.
    pub cure: Fault,
}

/// Every fault that the machine can have. `station` is whose switch is struck.
#[must_use]
pub fn every_fault(machine: &MachineDescription, station: usize) -> Vec<FaultCase> {
    let (here, next) = (Input::Station(station), Input::Station((station + 1) % machine.stations.len().max(1)));
    let case = |name: &str, fault: Fault, cure: Fault| FaultCase { name: name.into(), fault, cure };
    let stuck = |input: Input, level: bool| {
        (Fault::StuckInput { input, level: Some(level) }, Fault::StuckInput { input, level: None })
    };
    let mut cases = alloc::vec![
        case("emergency stop", Fault::EStop(true), Fault::EStop(false)),
        case("power loss", Fault::PowerLoss(true), Fault::PowerLoss(false)),
        case("origin detector double", Fault::DoubleOrigin(Some(rad_from_deg(90.0))), Fault::DoubleOrigin(None)),
        case(
            "limit switch bounces",
            Fault::BouncingSwitch { station, active: true },
            Fault::BouncingSwitch { station, active: false },
        ),
        case("limit switches shared", Fault::SharedInput(Some([here, next])), Fault::SharedInput(None)),
        case("switch and origin shared", Fault::SharedInput(Some([Input::Origin, here])), Fault::SharedInput(None)),
        case("one chunk lost", Fault::LostChunks(1), Fault::LostChunks(0)),
        case("every chunk lost", Fault::LostChunks(1_000_000), Fault::LostChunks(0)),
        case("wheel stops", Fault::WheelStall(true), Fault::WheelStall(false)),
        case("wheel overspeed", Fault::WheelOverspeed(1.3), Fault::WheelOverspeed(1.0)),
    ];
    for (name, input, level) in [
        ("origin detector dead", Input::Origin, false),
        ("origin detector stuck", Input::Origin, true),
        ("limit switch stuck open", here, false),
        ("limit switch stuck closed", here, true),
    ] {
        let (fault, cure) = stuck(input, level);
        cases.push(case(name, fault, cure));
    }
    for axis in Axis::ALL {
        let step = machine.axis(axis).max_following_error * 0.25;
        for (name, fault, cure) in [
            ("encoder step", Fault::EncoderOffset { axis, offset: step }, Fault::EncoderOffset { axis, offset: 0.0 }),
            ("blocked", Fault::DriveGain { axis, factor: 0.0 }, Fault::DriveGain { axis, factor: 1.0 }),
            ("drive trip", Fault::DriveFault { axis, active: true }, Fault::DriveFault { axis, active: false }),
        ] {
            cases.push(FaultCase { name: format!("{name}, {}", axis.joint()), fault, cure });
        }
    }
    if machine.gauge.is_some() {
        cases.push(case("gauge stuck", Fault::Gauge(Some(GaugeFault::Stuck)), Fault::Gauge(None)));
        cases.push(case("gauge not a number", Fault::Gauge(Some(GaugeFault::NotANumber)), Fault::Gauge(None)));
    }
    cases
}

/// `count` moments below `within`, in rising order, by Steele, Lea and Flood's `SplitMix64`.
#[must_use]
pub fn seeded_moments(seed: u64, count: usize, within: u64) -> Vec<u64> {
    let mut state = seed;
    let mut moments: Vec<u64> = (0..count)
        .map(|_| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ z >> 31) % within.max(1)
        })
        .collect();
    moments.sort_unstable();
    moments
}
