//! Feeds that LinuxCNC would drive faster than they are written.

use super::{BlockPlace, NcAxis, Program, driven};
use alloc::collections::BTreeSet;
use alloc::vec::Vec;
use thiserror::Error;

/// LinuxCNC makes a rate of an inverse time by the linear way of a block, and no rate is below this one (mm/min): `Interp::
/// inverse_time_rate_straight`, and issue 2410 of its repository, where a rotary axis with a very small linear way beside ran at its limit.
pub const LEAST_RATE_MM_MIN: f64 = 0.1;

/// What rounding of F may take off a rate.
const ROUNDING: f64 = 1e-6;

/// A block that would take less time than it says.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "{place}: {way_mm} mm in {time_s} s are {rate_mm_min} mm/min; LinuxCNC drives no less than {LEAST_RATE_MM_MIN} mm/min where a linear \
     axis moves, so C would be there after {driven_s} s"
)]
pub struct RaisedFeed {
    /// Which one.
    pub place: BlockPlace,
    /// The linear way (mm).
    pub way_mm: f64,
    /// Time that is written (s).
    pub time_s: f64,
    /// The rate that follows (mm/min).
    pub rate_mm_min: f64,
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
        let way_mm = way_mm(program, &start, &driven.pose);
        let rate_mm_min = way_mm * (60.0 / time_s);
        // Where no linear axis moves, the rate is one in degrees.
        let slow = way_mm > 0.0 && rate_mm_min < LEAST_RATE_MM_MIN * (1.0 + ROUNDING);
        if slow && known.insert((driven.subprogram, driven.block)) {
            let name = driven.subprogram.and_then(|index| program.subprograms.get(index)).map(|sub| sub.name.clone());
            raised.push(RaisedFeed {
                place: BlockPlace { subprogram: name, block: driven.block + 1 },
                way_mm,
                time_s,
                rate_mm_min,
                driven_s: way_mm * (60.0 / LEAST_RATE_MM_MIN),
            });
        }
    }
    raised
}

/// Linear way between two poses (mm). An axis that was nowhere before moves by an unknown way, which is left out.
fn way_mm(program: &Program, from: &[Option<i64>; 4], to: &[Option<i64>; 4]) -> f64 {
    let square = |axis: NcAxis| {
        let (Some(from), Some(to)) = (from[axis.index()], to[axis.index()]) else { return 0.0 };
        let way = program.format.value(axis, to.saturating_sub(from));
        way * way
    };
    libm::sqrt(square(NcAxis::X) + square(NcAxis::Y) + square(NcAxis::Z))
}
