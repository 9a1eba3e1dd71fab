// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The feeds between two rapids as one motion: C by a law over time, X and Z by laws over the angle of C, from rest to rest.

use super::ProgramMotionFault;
use super::rounded::{BrokenLine, CornerPosition, EndExtension};
use super::uses::{HeadstockUse, Slide, Use, worst_use};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use crate::math::hermite::HermiteSpline;
use crate::math::units::deg_from_rad;
use crate::motion::point_to_point::MOVE_SHARE;

/// Most blocks of a run, and most of them that one average sees.
const MAX_BLOCKS: usize = 1_000_000;
const MAX_IN_WINDOW: usize = 2_000;

/// Share of the limits that is used; what is missing covers rounding in the forward check.
const SPARE: f64 = 0.999;

/// Longest run-up (s), and by how much the next one is longer where X or Z cannot follow one.
const LONGEST_RAMP_S: f64 = 20.0;
const LONGER: f64 = 1.25;

/// Ratio of the window to the smallest sufficient one.
const NEAR: f64 = 1.01;

/// Share of a speed that keeps a limit exactly which is used, and the slowest share that is tried.
const SLOWED_SPARE: f64 = 0.999;
const SLOWEST_SHARE: f64 = 0.01;

/// A block that feeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FeedBlock {
    /// End position: C (rad), X and Z (mm) of the machine.
    pub(super) to: [f64; AXIS_COUNT],
    pub(super) time_s: f64,
    /// Its place in what the program does.
    pub(super) done: usize,
}

/// A run as a control would drive it.
#[derive(Debug, Clone, PartialEq)]
pub struct RunLaws {
    /// Angle of C since its start over time (rad over s), from rest to rest.
    pub speed: HermiteSpline,
    /// `x_axis` over the angle since its start (mm over rad).
    pub path: HermiteSpline,
    /// `z_axis` over the angle since its start (mm over rad).
    pub advance: HermiteSpline,
    /// Corners are averaged under a triangle that reaches so far to either side (rad).
    pub window_rad: f64,
    /// Maximum distance of X and Z from the programmed line (mm), both together.
    pub rounding_mm: f64,
    /// Speeds of C are averaged under a triangle that reaches so far to either side (s): C runs up, and down, in twice this time.
    pub ramp_s: f64,
    /// Angle of C in which it has run up, and in which it runs down (rad).
    pub ramps_rad: (f64, f64),
    /// Time that the blocks say (s); the run takes two ramps more.
    pub programmed_s: f64,
    /// Largest share of a limit that it uses, of acceleration and jerk of [`MOVE_SHARE`] of it.
    pub max_used: f64,
}

/// Why a run cannot be driven, and its block.
pub(super) type RunFault = (usize, ProgramMotionFault);

/// A run before its corners are rounded.
struct UnroundedRun {
    turning: BrokenLine,
    slides: [(Axis, BrokenLine); 2],
}

/// A run with windows that were tried.
struct RoundedTrial {
    ramp_s: f64,
    window_rad: f64,
    worst: Use,
}

impl RunLaws {
    /// Rounds as little as the axes allow, within a tolerance (mm).
    pub(super) fn new(
        from: [f64; AXIS_COUNT],
        feeds: &[FeedBlock],
        tolerance_mm: f64,
        machine: &MachineDescription,
    ) -> Result<Self, RunFault> {
        let first = feeds.first().map_or(0, |feed| feed.done);
        let wrong = |fault: ProgramMotionFault| (first, fault);
        if feeds.len() > MAX_BLOCKS {
            return Err(wrong(ProgramMotionFault::TooManyBlocks { count: feeds.len(), max: MAX_BLOCKS }));
        }
        no_block_is_too_fast(from, feeds, machine)?;
        let lines = UnroundedRun::new(from, feeds).map_err(wrong)?;
        let limits = Axis::ALL.map(|axis| usable(machine.axis(axis).limits));
        let widest_rad = lines.widest_window(tolerance_mm);
        lines.not_too_dense(widest_rad).map_err(wrong)?;
        let cycle_s = machine.cycle_time_s();
        let tried = lines.fitting(widest_rad, cycle_s, &limits).map_err(|tried| {
            let (at_rad, worst) = (tried.worst.at_rad, tried.worst);
            let block = feeds.partition_point(|feed| feed.to[0] - from[0] < at_rad).min(feeds.len() - 1);
            let fault = ProgramMotionFault::Limit {
                axis: worst.axis,
                quantity: worst.quantity,
                value: worst.value,
                allowed: worst.allowed,
                c_rad: from[0] + at_rad,
                window_rad: tried.window_rad,
                tolerance_mm,
            };
            (feeds[block].done, fault)
        })?;
        lines.laws(&tried).map_err(|source| wrong(source.into()))
    }

    /// The same, with all blocks slowed down by one share where an axis would exceed a limit; the blocks have their new times.
    pub(super) fn slowed(
        from: [f64; AXIS_COUNT],
        feeds: &mut [FeedBlock],
        tolerance_mm: f64,
        machine: &MachineDescription,
    ) -> Result<(Self, f64), RunFault> {
        let mut share = 1.0;
        loop {
            let (done, fault) = match Self::new(from, feeds, tolerance_mm, machine) {
                Ok(laws) => return Ok((laws, share)),
                Err(fault) => fault,
            };
            let slower = fault.speed_share().map(|slower| SLOWED_SPARE * slower);
            let Some(slower) = slower.filter(|slower| share * slower >= SLOWEST_SHARE) else {
                return Err((done, fault));
            };
            share *= slower;
            feeds.iter_mut().for_each(|feed| feed.time_s /= slower);
        }
    }

    /// Angle of C from its start to its end (rad).
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        self.path.end()
    }

    /// Time that it takes (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.speed.end()
    }
}

/// Limits that a run may use: a stop on the path needs the rest.
fn usable(limits: MotionLimits) -> MotionLimits {
    limits.with_share(SPARE * MOVE_SHARE)
}

/// Averages of slopes are never above the steepest, so a block that keeps its speed as it is written keeps it rounded.
fn no_block_is_too_fast(
    from: [f64; AXIS_COUNT],
    feeds: &[FeedBlock],
    machine: &MachineDescription,
) -> Result<(), RunFault> {
    let mut at = from;
    for feed in feeds {
        if feed.to[0] <= at[0] {
            let (from_deg, to_deg) = (deg_from_rad(at[0]), deg_from_rad(feed.to[0]));
            return Err((feed.done, ProgramMotionFault::NotForwards { from_deg, to_deg }));
        }
        for axis in Axis::ALL {
            let allowed = machine.axis(axis).limits.velocity;
            let speed = (feed.to[axis.index()] - at[axis.index()]).abs() / feed.time_s;
            if speed > allowed || speed.is_nan() {
                let time_s = feed.time_s;
                return Err((feed.done, ProgramMotionFault::TooFast { axis, time_s, speed, allowed }));
            }
        }
        at = feed.to;
    }
    Ok(())
}

impl UnroundedRun {
    fn new(from: [f64; AXIS_COUNT], feeds: &[FeedBlock]) -> Result<Self, ProgramMotionFault> {
        let mut time_s = 0.0;
        let mut turning = alloc::vec![CornerPosition { at: 0.0, value: 0.0 }];
        for feed in feeds {
            time_s += feed.time_s;
            turning.push(CornerPosition { at: time_s, value: feed.to[0] - from[0] });
        }
        let slide = |axis: Axis| {
            let begins = CornerPosition { at: 0.0, value: from[axis.index()] };
            let ends = |feed: &FeedBlock| CornerPosition { at: feed.to[0] - from[0], value: feed.to[axis.index()] };
            let places = core::iter::once(begins).chain(feeds.iter().map(ends)).collect();
            BrokenLine::new(places, EndExtension::Mirrored).map(|line| (axis, line))
        };
        Ok(Self { turning: BrokenLine::new(turning, EndExtension::Rest)?, slides: [slide(Axis::X)?, slide(Axis::Z)?] })
    }

    fn angle_rad(&self) -> f64 {
        self.slides[0].1.length()
    }

    /// Distance of X and Z from their lines for a window (mm).
    fn rounding_mm(&self, window_rad: f64) -> f64 {
        let [x, z] = [&self.slides[0].1, &self.slides[1].1].map(|line| line.rounded(window_rad).error());
        libm::hypot(x, z)
    }

    /// The widest window within a tolerance (rad), and no wider than the run.
    fn widest_window(&self, tolerance_mm: f64) -> f64 {
        let whole = self.angle_rad();
        let fits = |window: f64| {
            let in_window = self.slides.iter().map(|(_, line)| line.rounded(window).maximum_in_window());
            in_window.fold(0, usize::max) <= MAX_IN_WINDOW && self.rounding_mm(window) <= tolerance_mm
        };
        let (mut low, mut high) = (whole * 1e-9, whole);
        if fits(high) {
            return high;
        }
        while high > NEAR * low {
            let middle = libm::sqrt(low * high);
            if fits(middle) { low = middle } else { high = middle }
        }
        low
    }

    /// The widest window that can be averaged is no excuse for one that fits nothing.
    fn not_too_dense(&self, widest_rad: f64) -> Result<(), ProgramMotionFault> {
        let count =
            self.slides.iter().map(|(_, line)| line.rounded(widest_rad).maximum_in_window()).fold(0, usize::max);
        if count > MAX_IN_WINDOW {
            let window_deg = deg_from_rad(2.0 * widest_rad);
            return Err(ProgramMotionFault::TooDense { count, window_deg, max: MAX_IN_WINDOW });
        }
        Ok(())
    }

    /// The shortest ramp, and with it the smallest window, that all axes keep their limits with; the last that was tried where none will do.
    fn fitting(
        &self,
        widest_rad: f64,
        cycle_s: f64,
        limits: &[MotionLimits; AXIS_COUNT],
    ) -> Result<RoundedTrial, RoundedTrial> {
        let mut ramp_s = self.shortest_ramp(cycle_s, &limits[0]);
        loop {
            let turning = HeadstockUse::new(&self.turning.rounded(ramp_s).knots());
            let tried = |window_rad: f64| {
                let slides = [0, 1].map(|index| {
                    let (axis, line) = &self.slides[index];
                    Slide { axis: *axis, knots: line.rounded(window_rad).knots() }
                });
                RoundedTrial { ramp_s, window_rad, worst: worst_use(&turning, &slides, limits) }
            };
            let widest = tried(widest_rad);
            if widest.worst.ratio() <= 1.0 {
                return Ok(smallest(widest, cycle_s * turning.fastest_rad_s(), &tried));
            }
            ramp_s *= LONGER;
            if ramp_s > LONGEST_RAMP_S || !widest.worst.ramps {
                return Err(widest);
            }
        }
    }

    /// The shortest ramp that C itself keeps its limits with (s), and a cycle of the control at least.
    fn shortest_ramp(&self, cycle_s: f64, limits: &MotionLimits) -> f64 {
        let keeps = |ramp_s: f64| HeadstockUse::new(&self.turning.rounded(ramp_s).knots()).ratio(limits) <= 1.0;
        let (mut low, mut high) = (cycle_s, LONGEST_RAMP_S);
        if keeps(low) {
            return low;
        }
        while high > NEAR * low {
            let middle = libm::sqrt(low * high);
            if keeps(middle) { high = middle } else { low = middle }
        }
        high
    }

    fn laws(&self, tried: &RoundedTrial) -> Result<RunLaws, crate::math::hermite::HermiteError> {
        let RoundedTrial { ramp_s, window_rad, .. } = *tried;
        let places = self.turning.places();
        let mut knots = self.turning.rounded(ramp_s).knots();
        knots.iter_mut().for_each(|knot| knot.at += ramp_s);
        let speed = HermiteSpline::new(knots)?;
        let programmed_s = places[places.len() - 1].at;
        let (up, down) = (2.0 * ramp_s, speed.end() - 2.0 * ramp_s);
        Ok(RunLaws {
            path: self.slides[0].1.rounded(window_rad).spline()?,
            advance: self.slides[1].1.rounded(window_rad).spline()?,
            window_rad,
            rounding_mm: self.rounding_mm(window_rad),
            ramp_s,
            ramps_rad: (speed.sample(up).value, self.angle_rad() - speed.sample(down).value),
            programmed_s,
            max_used: tried.worst.ratio(),
            speed,
        })
    }
}

/// The smallest window that keeps the limits, between that of a cycle of the control and one that does.
fn smallest(widest: RoundedTrial, min_rad: f64, tried: &impl Fn(f64) -> RoundedTrial) -> RoundedTrial {
    if min_rad >= widest.window_rad {
        return widest;
    }
    let min = tried(min_rad);
    if min.worst.ratio() <= 1.0 {
        return min;
    }
    let (mut low, mut found) = (min_rad, widest);
    while found.window_rad > NEAR * low {
        let middle = tried(libm::sqrt(low * found.window_rad));
        if middle.worst.ratio() <= 1.0 { found = middle } else { low = middle.window_rad }
    }
    found
}
