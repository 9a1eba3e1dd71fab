// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The least position loop gain of X with which a part keeps its tolerance.

use super::{DrivesForm, DrivesResult, FlawEffect, TurningDrives, TurningDrivesError};
use crate::machine::description::{Axis, MachineDescription};
use crate::simulation::closed_loop::SimulationError;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Feed-forward of X while its gain is changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedForward {
    /// Present value of the drive.
    AsItIs,
    /// All of the setpoint's speed and acceleration.
    Whole,
}

/// Input of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainSearch {
    /// Permitted form error by the drives, see [`DrivesForm::beyond_mm`] (mm).
    pub tolerance_mm: f64,
    /// Largest gain that is tried (1/s). With it goes the bandwidth of the velocity loop, which the servo step bounds too.
    pub max_kv_1_s: f64,
    pub feed_forward: FeedForward,
}

/// A gain and what it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainTrial {
    /// Position loop gain of X (1/s).
    pub kv_1_s: f64,
    /// Bandwidth of its velocity loop (rad/s), changed by the same factor; `None`: ideal.
    pub velocity_loop_rad_s: Option<f64>,
    /// Form error; `None` if the machine stopped with an alarm by following error or an unstable loop.
    pub form: Option<DrivesForm>,
}

impl GainTrial {
    /// Returns whether a tolerance (mm) is kept.
    #[must_use]
    pub fn keeps(&self, tolerance_mm: f64) -> bool {
        self.form.is_some_and(|form| form.beyond_mm <= tolerance_mm)
    }

    fn beyond_mm(&self) -> f64 {
        self.form.map_or(f64::INFINITY, |form| form.beyond_mm)
    }
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub enum MinimumGain {
    /// A gain that keeps the tolerance.
    Found {
        least: GainTrial,
        /// The next smaller one that was tried and does not keep it, at most 5 % smaller; `None` where the smallest of all keeps it.
        below: Option<GainTrial>,
        /// All that were tried, by rising gain.
        tried: Vec<GainTrial>,
    },
    /// None up to the bound keeps it.
    NotFound {
        /// The gain that leaves least.
        best: GainTrial,
        /// The largest one that was tried (1/s).
        max_kv_1_s: f64,
        /// Best form error with each flaw of the drives removed, the most important first.
        flaws: Vec<FlawEffect>,
        /// All that were tried, by rising gain.
        tried: Vec<GainTrial>,
    },
}

/// The gains that are tried first, as multiples of the drive's own: √2 apart.
const STEP: f64 = core::f64::consts::SQRT_2;
const STEPS: core::ops::RangeInclusive<i32> = -6..=14;

/// Share of the bandwidth at which a velocity loop takes the whole deviation away in a servo step, which is refused.
const ROOM: f64 = 0.999;

/// Ratio of the smallest sufficient to the largest insufficient gain at the end of the search.
const NEAR: f64 = 1.05;

impl TurningDrives<'_> {
    /// The least gain of X that keeps a tolerance, the bandwidth of its velocity loop in the same ratio, all other drives as they are.
    ///
    /// From an eighth of the drive's own gain on upwards; a loop that answers faster follows better until the structure or the servo step
    /// makes it swing, so the first that keeps the tolerance after one that does not is bisected. Where none does, the flaws of the
    /// drives are omitted one after the other with the gain that leaves least.
    ///
    /// # Errors
    /// A tolerance or a bound that is none; what [`Self::form`] says, but for alarms of the machine, which count as not keeping it.
    pub fn minimum_gain(
        &self,
        search: &GainSearch,
        mut report: impl FnMut(&DrivesResult),
    ) -> Result<MinimumGain, TurningDrivesError> {
        let own = self.machine().axis(Axis::X).drive;
        let max_kv_1_s = self.largest_gain(search)?;
        let mut tried: Vec<GainTrial> = Vec::new();
        let mut failed: Option<GainTrial> = None;
        let mut kept: Option<GainTrial> = None;
        for step in STEPS {
            let kv_1_s = (own.kv_1_s * libm::pow(STEP, f64::from(step))).min(max_kv_1_s);
            if tried.last().is_some_and(|last| last.kv_1_s >= kv_1_s) {
                break;
            }
            let gain = self.tried(search, kv_1_s, &mut report)?;
            tried.push(gain);
            if gain.keeps(search.tolerance_mm) {
                kept = Some(gain);
                break;
            }
            failed = Some(gain);
        }
        let Some(mut least) = kept else { return self.not_found(search, tried, report) };
        while let Some(below) = failed.filter(|below| least.kv_1_s > NEAR * below.kv_1_s) {
            let gain = self.tried(search, libm::sqrt(below.kv_1_s * least.kv_1_s), &mut report)?;
            tried.push(gain);
            if gain.keeps(search.tolerance_mm) { least = gain } else { failed = Some(gain) }
        }
        tried.sort_by(|a, b| a.kv_1_s.total_cmp(&b.kv_1_s));
        Ok(MinimumGain::Found { least, below: failed, tried })
    }

    fn not_found(
        &self,
        search: &GainSearch,
        tried: Vec<GainTrial>,
        report: impl FnMut(&DrivesResult),
    ) -> Result<MinimumGain, TurningDrivesError> {
        let best =
            tried.iter().copied().reduce(|best, one| if one.beyond_mm() < best.beyond_mm() { one } else { best });
        let (Some(best), Some(last)) = (best, tried.last()) else { return Err(self.out_of_range(search.max_kv_1_s)) };
        let max_kv_1_s = last.kv_1_s;
        let machine = self.with_gain(search, best.kv_1_s);
        let flaws = if best.form.is_some() { self.without_flaws(&machine, report)? } else { Vec::new() };
        Ok(MinimumGain::NotFound { best, max_kv_1_s, flaws, tried })
    }

    /// The largest gain that may be tried: a velocity loop takes no more than the whole deviation away in a servo step.
    fn largest_gain(&self, search: &GainSearch) -> Result<f64, TurningDrivesError> {
        let GainSearch { tolerance_mm, max_kv_1_s, .. } = *search;
        if !(tolerance_mm > 0.0 && tolerance_mm.is_finite()) {
            let what = "the tolerance (mm)";
            return Err(TurningDrivesError::OutOfRange { what, value: tolerance_mm, allowed: "above 0".into() });
        }
        let drive = self.machine().axis(Axis::X).drive;
        let machine = self.machine();
        let step_s = machine.cycle_time_s() / f64::from(machine.servo_steps_per_tick.max(1));
        let max =
            drive.velocity_loop_rad_s.map_or(f64::INFINITY, |loop_rad_s| ROOM * drive.kv_1_s / (loop_rad_s * step_s));
        let smallest = drive.kv_1_s * libm::pow(STEP, f64::from(*STEPS.start()));
        if !(max_kv_1_s >= smallest && max_kv_1_s.is_finite()) {
            return Err(self.out_of_range(max_kv_1_s));
        }
        Ok(max_kv_1_s.min(max))
    }

    fn out_of_range(&self, value: f64) -> TurningDrivesError {
        let smallest = self.machine().axis(Axis::X).drive.kv_1_s * libm::pow(STEP, f64::from(*STEPS.start()));
        let allowed: String = format!("at least {smallest:.1} 1/s, an eighth of what X has");
        TurningDrivesError::OutOfRange { what: "the largest gain of X (1/s)", value, allowed }
    }

    /// The machine with another gain of X.
    fn with_gain(&self, search: &GainSearch, kv_1_s: f64) -> MachineDescription {
        let mut machine = self.machine().clone();
        let drive = &mut machine.axes[Axis::X.index()].drive;
        let times = kv_1_s / drive.kv_1_s;
        drive.kv_1_s = kv_1_s;
        drive.velocity_loop_rad_s = drive.velocity_loop_rad_s.map(|loop_rad_s| times * loop_rad_s);
        if search.feed_forward == FeedForward::Whole {
            (drive.velocity_feed_forward, drive.acceleration_feed_forward) = (1.0, 1.0);
        }
        machine
    }

    fn tried(
        &self,
        search: &GainSearch,
        kv_1_s: f64,
        report: &mut impl FnMut(&DrivesResult),
    ) -> Result<GainTrial, TurningDrivesError> {
        let machine = self.with_gain(search, kv_1_s);
        let form = match self.form(&machine) {
            Ok(form) => Some(form),
            Err(TurningDrivesError::Simulation(SimulationError::Alarm(_) | SimulationError::NotSettled)) => None,
            Err(error) => return Err(error),
        };
        let velocity_loop_rad_s = machine.axis(Axis::X).drive.velocity_loop_rad_s;
        let gain = GainTrial { kv_1_s, velocity_loop_rad_s, form };
        report(&DrivesResult::Gain(gain));
        Ok(gain)
    }
}
