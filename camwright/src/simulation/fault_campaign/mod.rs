// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Every fault at many moments of a job, from copies of the cell in the middle of it: whether the axes come to rest, with an
//! alarm, with the wheel off the part and nothing restarted, and how deep the part was cut below its design at worst.
//!
//! The bound of the deepest cut is computed from the axes alone, without the part:
//! ```text
//! bound = deepest cut of the job without a fault             drives, wear, whatever else the machine leaves
//!       + normal following error                             from the fault until the axes rest, beyond that of the setpoints
//!       + lag of the retreat                                 where C's or X's drive fails: how far the path rises above X
//!       + a t²/8                                             what X may do between two ticks, at which this is looked at
//! ```
//! The wheel at x and C lies P(C) − x inside the path P of the finished contour, and a wheel that lies d nearer to the axis
//! than where it touches cuts no deeper than d along any normal. Where C and X both work the setpoints stay on or outside
//! the path, so only the following error counts. Where one fails, C brakes at its limit from its true speed, and X moves by
//! the law of its retreat, or brakes and is drawn back, each with its structure swinging on: the largest P(C(t)) − x(t) beyond
//! that at the alarm is the lag. A drive that took a jump of its encoder for an error has pushed as hard as it can for some of a
//! tick before the alarm, so what its slide and its structure do at the alarm is part of that.
//! Wheel and part deflecting to each other only make the cut less deep; that the wheel wears, too.

mod cases;
mod swing;

use crate::interpolator::Prepared;
use crate::machine::alarm::Alarm;
use crate::machine::description::{Axis, MachineDescription};
use crate::machine::setpoint::Setpoint;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{CutSegment, Plan};
use crate::motion::point_to_point::{solve, stop, whole_ticks};
use crate::planner::LobeDesign;
use crate::simulation::closed_loop::ClosedLoop;
use crate::simulation::fault::Fault;
use crate::simulation::plausibility::DRIVE_HEADROOM;
use crate::simulation::tick_report::{MotionState, TickReport};
use alloc::boxed::Box;
use alloc::vec::Vec;
pub use cases::{FaultCase, every_fault, seeded_moments};
use swing::FreeOscillation;

const C: usize = Axis::C as usize;
const X: usize = Axis::X as usize;

/// Ticks within which the axes must rest after an alarm.
const REST_TICKS: u64 = 10_000;
/// Ticks after rest in which nothing may move.
const QUIET_TICKS: u64 = 100;
/// Permitted reduction of the wheel's clearance at a stop (mm): with X held, two counts of rounding; with X retracted by weight or
/// spring, the tolerance of a brake.
const CLEARANCE_SLACK_MM: [f64; 2] = [1.0e-4, 0.1];

/// The cell in the middle of a job.
#[derive(Debug, Clone)]
pub struct Keyframe {
    /// The cell before this tick.
    pub tick: u64,
    /// Station of the lobe that is cut next: a switch that nobody presses any more can fail unseen.
    pub station: usize,
    cell: ClosedLoop,
}

/// A job to be struck.
#[derive(Debug)]
pub struct Campaign<'a> {
    plan: &'a Plan,
    lobes: Vec<CampaignTarget<'a>>,
    motion: Prepared,
    /// Deepest cut below the design that the job leaves without a fault, at any moment (mm).
    pub healthy_mm: f64,
    cycle_s: f64,
    /// First tick of the job, and the last in which something was cut.
    pub ticks: (u64, u64),
}

#[derive(Debug)]
struct CampaignTarget<'a> {
    design: &'a LobeDesign,
    cut: &'a CutSegment,
    /// C where the cut begins (rad).
    start_rad: f64,
    /// Radius of the design at the azimuths of the part (mm).
    radii_mm: Vec<f64>,
}

/// Result of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseResult {
    pub alarm: Alarm,
    /// Ticks from the fault to the alarm, and from there to rest.
    pub ticks: (u64, u64),
    /// Deepest cut below the design (mm).
    pub deepest_mm: f64,
    /// Normal following error of the bound (mm).
    pub following_error_mm: f64,
    /// Lag of the retreat in the bound (mm).
    pub lag_mm: f64,
    /// The bound (mm).
    pub bound_mm: f64,
    /// Distance of the wheel from the lobe in front of it (mm).
    pub gap_mm: Option<f64>,
}

/// Why a case failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CaseFailure {
    /// The job went on to its end.
    #[error("no alarm")]
    NoAlarm,
    /// The axes do not rest.
    #[error("alarm {}: the axes are not at rest {REST_TICKS} ticks later", .0.kind.entry().number)]
    Restless(Alarm),
    /// The wheel is at the part.
    #[error("alarm {}: the wheel rests {gap_mm:.3} mm from the part", alarm.kind.entry().number)]
    AtThePart {
        alarm: Alarm,
        /// Its distance from the lobe's farthest point (mm).
        gap_mm: f64,
    },
    /// Something moved before a reset, or by it.
    #[error("alarm {}: something moved {when}", alarm.kind.entry().number)]
    Restarted { alarm: Alarm, when: &'static str },
    /// Cut deeper than the bound.
    #[error(
        "alarm {}: cut {:.4} mm below the design, the bound is {:.4} mm", .0.alarm.kind.entry().number, .0.deepest_mm, .0.bound_mm
    )]
    TooDeep(Box<CaseResult>),
}

impl<'a> Campaign<'a> {
    /// Runs the job of a plan without a fault from a cell whose part is loaded, and keeps the cell at these ticks after the
    /// first (in rising order). `designs` are the lobes in the order of the plan's.
    ///
    /// # Errors
    /// The alarm that ended the job, or none if it did not come to its end.
    pub fn new(
        plan: &'a Plan,
        designs: &[&'a LobeDesign],
        motion: Prepared,
        mut cell: ClosedLoop,
        moments: &[u64],
    ) -> Result<(Self, Vec<Keyframe>), Option<Alarm>> {
        let azimuths = |design: &LobeDesign| {
            let count = cell.machine().part().lobe(&design.name).map_or(0, |lobe| lobe.radii_mm().len());
            (0..count).map(|i| design.radius_at(i as f64 * TURN_RAD / count as f64)).collect()
        };
        let cycle_s = cell.machine().description().cycle_time_s();
        let lobes = designs.iter().enumerate().filter_map(|(index, design)| {
            let cut = plan.cuts_of(index).last()?;
            let start_rad = cell.machine().description().axis(Axis::C).scale.position(cut.start_counts);
            Some(CampaignTarget { design, cut, start_rad, radii_mm: azimuths(design) })
        });
        let mut campaign = Self { plan, lobes: lobes.collect(), motion, healthy_mm: 0.0, cycle_s, ticks: (0, 0) };
        cell.start(Box::new(campaign.motion.clone())).map_err(|_| None)?;
        let first = cell.machine().tick() + 1;
        campaign.ticks = (first, first);
        let (mut frames, mut lobe) = (Vec::<Keyframe>::new(), None);
        let mut of_next_station = 0;
        while cell.is_running() || !cell.machine().is_at_rest() {
            let tick = cell.machine().tick() + 1;
            if moments.get(frames.len()).is_some_and(|moment| first + moment <= tick) {
                frames.push(Keyframe { tick, station: 0, cell: cell.clone() });
            }
            let report = cell.step(&[]);
            if let Some(station) = campaign.station_of(&cell, &report).filter(|_| report.removal.area_mm2 > 0.0) {
                frames[of_next_station..].iter_mut().for_each(|frame| frame.station = station);
                of_next_station = frames.len();
            }
            if let Some(alarm) = report.stopping_alarm() {
                return Err(Some(alarm));
            }
            if report.removal.area_mm2 > 0.0 {
                campaign.ticks.1 = report.tick;
            }
            if report.lobe != lobe {
                lobe = report.lobe;
                // A lobe is done, or one begins.
                campaign.healthy_mm = campaign.healthy_mm.max(campaign.deepest_mm(&cell));
            }
        }
        campaign.healthy_mm = campaign.healthy_mm.max(campaign.deepest_mm(&cell));
        Ok((campaign, frames))
    }

    /// Station of the lobe in front of the wheel.
    fn station_of(&self, cell: &ClosedLoop, report: &TickReport) -> Option<usize> {
        let name = cell.machine().part().lobes().get(report.lobe?)?.name();
        let target = self.lobes.iter().find(|target| target.design.name == name)?;
        let stations = &cell.machine().description().stations;
        stations.iter().position(|station| station.switch == target.design.station)
    }

    /// Ticks since the job's first in which it can be struck so that every fault shows: until one and a half turns before the
    /// last cut is over.
    #[must_use]
    pub fn struck_within(&self) -> u64 {
        let cycle_s = self.cycle_s;
        let turn_s = self.lobes.last().map_or(0.0, |target| target.cut.turn_s);
        (self.ticks.1 - self.ticks.0).saturating_sub(whole_ticks(1.5 * turn_s, cycle_s)).max(1)
    }

    /// Deepest cut below the design over every lobe (mm), along the contour's normal; 0 where none is.
    #[must_use]
    pub fn deepest_mm(&self, cell: &ClosedLoop) -> f64 {
        let mut deepest = 0.0_f64;
        for target in &self.lobes {
            let Some(lobe) = cell.machine().part().lobe(&target.design.name) else { continue };
            for (i, (radius, design)) in lobe.radii_mm().iter().zip(&target.radii_mm).enumerate() {
                // Along the ray it is never less than along the normal.
                if design - radius > deepest {
                    let azimuth = i as f64 * TURN_RAD / target.radii_mm.len() as f64;
                    let (off_mm, _) = target.design.contour.distance(*radius, azimuth - target.design.phase_rad);
                    deepest = deepest.max(-off_mm);
                }
            }
        }
        deepest
    }

    /// Strikes a copy of the cell, and judges what comes of it.
    ///
    /// # Errors
    /// What did not happen as it must.
    pub fn run_case(&self, frame: &Keyframe, case: &FaultCase) -> Result<CaseResult, CaseFailure> {
        let mut cell = frame.cell.clone();
        let mut faults: &[Fault] = core::slice::from_ref(&case.fault);
        let mut detecting_mm = 0.0_f64;
        let (alarm, mut report) = loop {
            let report = cell.step(faults);
            faults = &[];
            detecting_mm = detecting_mm.max(self.error_mm(self.state(&cell, &report)));
            if let Some(alarm) = report.stopping_alarm() {
                break (alarm, report);
            }
            if !cell.is_running() && cell.machine().is_at_rest() {
                return Err(CaseFailure::NoAlarm);
            }
        };
        let tick = report.tick;
        let rising_mm = self.rising_mm(cell.machine().description(), &report, self.state(&cell, &report));
        let mut stopping_mm = 0.0_f64;
        while !(cell.machine().is_at_rest() && report.motion == MotionState::Fault) {
            if report.tick > tick + REST_TICKS {
                return Err(CaseFailure::Restless(alarm));
            }
            report = cell.step(&[]);
            stopping_mm = stopping_mm.max(self.error_mm(self.state(&cell, &report)));
        }
        let error_mm = detecting_mm.max(stopping_mm);
        let lag_mm = detecting_mm.max(rising_mm + stopping_mm) - error_mm;
        let rest_tick = report.tick;
        let deepest_mm = self.deepest_mm(&cell);
        let finding = CaseResult {
            alarm,
            ticks: (tick - frame.tick, rest_tick - tick),
            deepest_mm,
            following_error_mm: error_mm,
            lag_mm,
            bound_mm: self.healthy_mm + error_mm + lag_mm + between_ticks_mm(cell.machine().description()),
            gap_mm: cell.machine().wheel_gap_mm(),
        };
        let slack_mm = CLEARANCE_SLACK_MM[usize::from(!report.axes[X].is_powered)];
        let clearance_mm = cell.machine().description().retract.clearance_mm - slack_mm;
        if let Some(gap_mm) = finding.gap_mm.filter(|gap| *gap < clearance_mm) {
            return Err(CaseFailure::AtThePart { alarm, gap_mm });
        }
        self.must_stay(&mut cell, case, alarm)?;
        if finding.deepest_mm > finding.bound_mm {
            return Err(CaseFailure::TooDeep(Box::new(finding)));
        }
        Ok(finding)
    }

    /// Nothing moves before a reset, whatever is sent, and nothing moves by the reset.
    fn must_stay(&self, cell: &mut ClosedLoop, case: &FaultCase, alarm: Alarm) -> Result<(), CaseFailure> {
        let place = cell.machine().truth();
        let moved = |cell: &ClosedLoop| cell.machine().truth() != place;
        let restarted = |when: &'static str| CaseFailure::Restarted { alarm, when };
        for _ in 0..QUIET_TICKS {
            let beyond = Setpoint { counts: [1; 3], ..cell.machine().setpoint() };
            let first_tick = cell.machine().tick() + 1;
            let chunk = crate::simulation::buffer::Chunk { first_tick, dense: &[beyond], tail: &[], is_final: true };
            if cell.offer(&chunk).is_ok() || cell.start(Box::new(self.motion.clone())).is_ok() {
                return Err(restarted("that was sent without a reset"));
            }
            cell.step(&[]);
        }
        if moved(cell) {
            return Err(restarted("without a reset"));
        }
        cell.step(core::slice::from_ref(&case.cure));
        // An encoder that reads right again is another jump.
        for _ in 0..1000 {
            cell.step(&[]);
        }
        let place = cell.machine().truth();
        if cell.reset().is_err() {
            return Err(restarted("that cannot be reset"));
        }
        for _ in 0..QUIET_TICKS {
            cell.step(&[]);
        }
        if cell.machine().truth() != place { Err(restarted("after a reset")) } else { Ok(()) }
    }

    /// Axes at the lobe in front of the wheel.
    fn state(&self, cell: &ClosedLoop, report: &TickReport) -> Option<MachineMoment> {
        let machine = cell.machine();
        let name = machine.part().lobes().get(report.lobe?)?.name();
        let target = self.lobes.iter().position(|target| target.design.name == name)?;
        let (truth, swings) = (machine.truth(), machine.swings());
        // A drive without power has no setpoint, and before C is homed only the true position is known.
        let set = |axis: Axis| {
            let own = &report.axes[axis.index()];
            let scale = machine.description().axis(axis).scale;
            if own.is_powered && own.is_homed { scale.position(own.setpoint_counts) } else { truth[axis.index()].0 }
        };
        Some(MachineMoment {
            target,
            c_rad: truth[C].0,
            c_set_rad: set(Axis::C),
            x_mm: truth[X].0,
            x_set_mm: set(Axis::X),
            c_rad_s: truth[C].1,
            x_mm_s: truth[X].1,
            c_swing: swings[C],
            x_swing: swings[X],
        })
    }

    /// X on the path of the finished contour (mm).
    fn path_mm(&self, target: usize, c_rad: f64) -> f64 {
        let target = &self.lobes[target];
        self.plan.paths[target.cut.path].sample(target.cut.path_start_rad + c_rad - target.start_rad).value
    }

    /// Depth of the wheel in the path beyond its setpoints, if they lie on the path or outside (mm).
    fn error_mm(&self, state: Option<MachineMoment>) -> f64 {
        let Some(state) = state else { return 0.0 };
        let inside_mm = self.path_mm(state.target, state.c_rad) - state.x_mm;
        let asked_mm = self.path_mm(state.target, state.c_set_rad) - state.x_set_mm;
        (inside_mm - asked_mm.max(0.0)).max(0.0)
    }

    /// Rise of the path above X after an alarm that removes power from the drive of C or X (mm).
    fn rising_mm(&self, machine: &MachineDescription, report: &TickReport, state: Option<MachineMoment>) -> f64 {
        let [c_dead, x_dead] = [C, X].map(|i| !report.axes[i].is_powered);
        let Some(state) = state.filter(|_| c_dead || x_dead) else { return 0.0 };
        let (c, x) = (machine.axis(Axis::C), machine.axis(Axis::X));
        let tick_s = machine.cycle_time_s();
        let inside = |c_rad: f64, x_mm: f64| self.path_mm(state.target, c_rad) - x_mm;
        let mut worst_mm = inside(state.c_rad, state.x_mm).max(0.0);
        let mut swings = [(c, state.c_swing, c_dead), (x, state.x_swing, x_dead)]
            .map(|(axis, swing, is_dead)| FreeOscillation::new(axis.drive.structure.filter(|_| is_dead), swing));
        let brake = c.limits.acceleration;
        // X goes by the law of its retreat, over what is surely enough to leave; or it brakes and is drawn back.
        let (v0, far_mm) = (state.x_mm_s, 100.0_f64);
        let braking = stop(0.0, v0, 0.0, &x.limits);
        let law = solve(far_mm.max(braking.sample(braking.duration()).value), v0, 0.0, 0.0, &x.limits);
        let (mut drawn_mm, mut drawn_mm_s) = (0.0, v0);
        let steps = machine.servo_steps_per_tick.max(1);
        let step_s = tick_s / f64::from(steps);
        let c_stop_s = state.c_rad_s.abs() / brake;
        // Until the path stands still and X is on its way out, and a turn of the slowest swing beyond.
        let swing_s = swings.iter().map(FreeOscillation::period_s).fold(0.0, f64::max);
        let end_s = c_stop_s.max(v0.abs() / x.limits.acceleration) + swing_s + 4.0 * tick_s;
        let mut at_s = 0.0;
        while at_s <= end_s {
            let c_change = if at_s < c_stop_s { -libm::copysign(brake, state.c_rad_s) } else { 0.0 };
            at_s += step_s;
            let braked_s = at_s.min(c_stop_s);
            let way = (state.c_rad_s.abs() * braked_s - 0.5 * brake * braked_s * braked_s).max(0.0);
            let c_rad = state.c_rad + libm::copysign(way, state.c_rad_s) + swings[0].after(c_change, step_s);
            let x_before_mm_s = drawn_mm_s;
            let x_mm = if x_dead {
                let pull = if drawn_mm_s < 0.0 { x.limits.acceleration } else { machine.retract.drawback_mm_s2 };
                let after = drawn_mm_s + pull * step_s;
                let after = if drawn_mm_s < 0.0 { after.min(0.0) } else { after };
                drawn_mm += 0.5 * (drawn_mm_s + after) * step_s;
                drawn_mm_s = after;
                drawn_mm
            } else {
                // A tick passes before it is asked for.
                let since_s = (at_s - tick_s).max(0.0);
                law.sample(since_s).value + v0 * (at_s - since_s)
            };
            let x_swung_mm = swings[1].after((drawn_mm_s - x_before_mm_s) / step_s, step_s);
            worst_mm = worst_mm.max(inside(c_rad, state.x_mm + x_mm + x_swung_mm));
        }
        worst_mm
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct MachineMoment {
    target: usize,
    c_rad: f64,
    c_set_rad: f64,
    x_mm: f64,
    x_set_mm: f64,
    c_rad_s: f64,
    x_mm_s: f64,
    /// Deflection of the structures (mm or rad), and its rate (1/s).
    c_swing: (f64, f64),
    x_swing: (f64, f64),
}

/// Motion of an axis between two ticks that a check per tick misses: the sagitta of its largest acceleration (mm).
fn between_ticks_mm(machine: &MachineDescription) -> f64 {
    let tick_s = machine.cycle_time_s();
    machine.axis(Axis::X).limits.acceleration * DRIVE_HEADROOM * tick_s * tick_s / 8.0
}

#[cfg(test)]
mod tests;
