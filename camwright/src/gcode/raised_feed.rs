// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Feeds that LinuxCNC would drive faster than they are written.

use super::{BlockLocation, NcAxis, Program, driven};
use crate::math::units::deg_from_rad;
use alloc::collections::BTreeSet;
use alloc::vec::Vec;
use thiserror::Error;

/// LinuxCNC makes a rate of an inverse time by the linear way of a block (of C where no linear axis moves, in degrees), and no rate is below
/// this one (mm/min): `Interp::inverse_time_rate_straight`, and issue 2410 of its repository, where a rotary axis with a very small linear
/// way beside ran at its limit.
pub const MIN_RATE_MM_MIN: f64 = 0.1;

/// Relative error of a rate by the rounding of F.
const ROUNDING: f64 = 1e-6;

/// A block that would take less time than it says.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "{place}: {way} {unit} in {time_s} s are {rate_per_min} {unit}/min; LinuxCNC drives no less than {MIN_RATE_MM_MIN} {unit}/min, so C \
     would be there after {driven_s} s"
)]
pub struct RaisedFeed {
    pub place: BlockLocation,
    /// The way that its rate is made of: that of the linear axes, or of C where none of them moves.
    pub way: f64,
    /// Unit of the distance: `mm` or `deg`.
    pub unit: &'static str,
    /// Time that is written (s).
    pub time_s: f64,
    /// The rate that follows (1/min).
    pub rate_per_min: f64,
    /// Time that it would take (s).
    pub driven_s: f64,
}

/// The blocks of a program that LinuxCNC would drive too fast, each once, in the order in which they are driven.
#[must_use]
pub fn raised_feeds(program: &Program) -> Vec<RaisedFeed> {
    let mut raised = Vec::new();
    let mut known = BTreeSet::new();
    let mut from = [None; 4];
    for driven in driven(program) {
        let start = core::mem::replace(&mut from, driven.pose);
        let Some(time_s) = driven.time_s else { continue };
        let Some((way, unit)) = distance_for_rate(program, &start, &driven.pose) else { continue };
        let rate_per_min = way * (60.0 / time_s);
        let slow = way > 0.0 && rate_per_min < MIN_RATE_MM_MIN * (1.0 + ROUNDING);
        if slow && known.insert((driven.subprogram, driven.block)) {
            let name = driven.subprogram.and_then(|index| program.subprograms.get(index)).map(|sub| sub.name.clone());
            raised.push(RaisedFeed {
                place: BlockLocation { subprogram: name, block: driven.block + 1 },
                way,
                unit,
                time_s,
                rate_per_min,
                driven_s: way * (60.0 / MIN_RATE_MM_MIN),
            });
        }
    }
    raised
}

/// The way between two poses by which LinuxCNC makes a rate of a time, and its unit; `None` where an axis was nowhere before.
fn distance_for_rate(program: &Program, from: &[Option<i64>; 4], to: &[Option<i64>; 4]) -> Option<(f64, &'static str)> {
    let way = |axis: NcAxis| {
        let Some(to) = to[axis.index()] else { return Some(0.0) };
        Some(program.format.value(axis, to.saturating_sub(from[axis.index()]?)))
    };
    let mut square = 0.0;
    for axis in [NcAxis::X, NcAxis::Y, NcAxis::Z] {
        square += way(axis)? * way(axis)?;
    }
    let turn_deg = libm::fabs(deg_from_rad(way(NcAxis::C)?));
    Some(if square > 0.0 { (libm::sqrt(square), "mm") } else { (turn_deg, "deg") })
}
