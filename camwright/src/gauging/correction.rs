// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The turn that makes the part round.
//!
//! A phase at r that is to leave the wheel at r* must meet it at
//!
//! ```text
//!  L = [r* (kg + km) − kg r − F0]/km = r* − F0/km − (kg/km)(r − r*):
//! ```
//! where r − r* more is to be cut, (kg/km)(r − r*) more is given way. Every phase is cut if r* is no larger than the least radius.
//!
//! Over the turn from C0 on, the radii to be met are r(C − 2π), and they differ between its begin and its end by the last depth of cut
//! there: a phase beside C0 has just been cut, one beyond it has not since a turn. So L ends farther out than it began, and with C0 where
//! the least radius has just been left, all fits together. L begins where the wheel stands, without a step and without slope, and ends
//! at r* − F0/km, where the wheel takes nothing: it can stay, or leave at leisure.
//!
//! ```text
//! x  ──────╮          ╭──────╮ ╭───── ends at r* − F0/km
//!  stays   ╰──╮    ╭──╯      ╰─╯
//!             ╰────╯
//!          C0                C0 + 2π
//! ```
//! Finishing turns can follow; the correction then leaves their depth, and [`Finishing`] the size.
//!
//! Paths of a plan are periodic, so the correction has two parts: a periodic path over C, and a ramp over the angle since C0, from that
//! difference to 0, which is added as an infeed.

use super::GaugingMode;
use super::finishing::Finishing;
use super::runout::RadiusByPhase;
use super::runout::{PhasesError, phase_rad};
use super::state::{PartState, StateError};
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::MotionLimits;
use crate::math::extremum::golden_section;
use crate::math::hermite::{HermiteError, HermiteSpline, Knot};
use crate::math::periodic_spline::{PeriodicSpline, PeriodicSplineError, Sample};
use crate::math::units::{TURN_RAD, um_from_mm, wrap_turn};
use alloc::vec::Vec;
use thiserror::Error;

/// Places per phase at which a correction is proven and its derivatives are looked at.
const PARTS: u32 = 4;

/// Share of the runout that may be left where the path is looked at between phases: as much as is promised without noise. With noise
/// as much as it is: a curve through noisy phases has no truth between them.
pub(super) const LEFT_SHARE: f64 = 0.01;

/// Permitted remaining error (mm): the resolution of a good gauge.
pub(super) const LEFT_MM: f64 = 1e-4;

/// To which radius the turn cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CorrectionTarget {
    /// To the least radius, less a depth (mm, 0 or more) that every phase loses in addition. At 0 the turn begins and ends without a step.
    MinRadius {
        /// The depth (mm).
        extra_depth_mm: f64,
    },
    /// To this radius (mm): size and runout in one turn.
    Radius(f64),
}

/// Start of the turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CorrectionStart {
    /// The angle at which the minimum radius leaves the wheel, the first such angle of the headstock from this one on (rad): the correction
    /// can be ready by then. The part turns forward to it, with the wheel at its last logged position.
    AtMinRadius {
        /// Earliest (rad).
        from_rad: f64,
    },
    /// At this angle (rad), whatever step that costs: for a wheel that is clear of the part.
    At(f64),
}

/// Why there is no correction.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CorrectionError {
    /// The correction would begin while the log still runs, or somewhere that is no angle.
    #[error("correction from C = {start_rad} rad, but wheel positions are logged up to {logged_rad} rad")]
    BeforeLogEnds {
        /// Start wanted (rad).
        start_rad: f64,
        /// End of the log (rad).
        logged_rad: f64,
    },
    /// The circle is larger than the part.
    #[error(
        "target radius {target_mm:.5} mm is {:.3} um above the least radius {min_mm:.5} mm: that phase would not be cut",
        um_from_mm(*.target_mm - *.min_mm)
    )]
    TargetAboveMin {
        /// Target (mm).
        target_mm: f64,
        /// Least radius (mm).
        min_mm: f64,
    },
    /// An extra depth that is none.
    #[error("extra depth {extra_depth_mm} mm must be 0 or more")]
    ExtraDepth {
        /// Given value (mm).
        extra_depth_mm: f64,
    },
    /// The path between the phases is not what the part needs.
    #[error(
        "correction leaves {:.3} um between its {phases} phases, at most {:.3} um are allowed: the part has a step that no phase shows",
        um_from_mm(*.left_mm), um_from_mm(*.allowed_mm)
    )]
    NotResolved {
        /// Runout left, found by grinding the path (mm).
        left_mm: f64,
        /// Allowed (mm).
        allowed_mm: f64,
        phases: usize,
    },
    /// A wheel position that is no number.
    #[error("wheel position {wheel_mm} mm is not a finite number")]
    Wheel {
        /// Given value (mm).
        wheel_mm: f64,
    },
    /// Radii that are no numbers.
    #[error(transparent)]
    Phases(#[from] PhasesError),
    /// Radii that make no curve.
    #[error(transparent)]
    State(#[from] StateError),
    /// A path that is none.
    #[error(transparent)]
    Path(#[from] PeriodicSplineError),
    /// A ramp that is none.
    #[error(transparent)]
    Ramp(#[from] HermiteError),
}

/// Predicted result of grinding the path, by the contact law, phase after phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// Runout before (mm).
    pub before_mm: f64,
    /// Radius after (mm).
    pub radius_mm: f64,
    /// Runout after, as far as the gauge knew the part (mm).
    pub left_mm: f64,
    /// Least and largest depth of cut of the turn that corrects (mm).
    pub depth_mm: (f64, f64),
}

/// Largest magnitudes of the derivatives of `x_axis` with respect to C over the turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steepness {
    /// First (mm/rad).
    pub first_mm_rad: f64,
    /// Second (mm/rad²).
    pub second_mm_rad2: f64,
    /// Third (mm/rad³).
    pub third_mm_rad3: f64,
}

impl Steepness {
    /// The fastest constant work speed (rad/s) at which `x_axis` keeps its limits.
    #[must_use]
    pub fn fastest_rad_s(&self, x: MotionLimits) -> f64 {
        let by_velocity = x.velocity / self.first_mm_rad;
        let by_acceleration = libm::sqrt(x.acceleration / self.second_mm_rad2);
        let by_jerk = libm::cbrt(x.jerk / self.third_mm_rad3);
        by_velocity.min(by_acceleration).min(by_jerk)
    }
}

/// One turn of `x_axis` over C, and finishing turns after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    mode: GaugingMode,
    start_rad: f64,
    path: PeriodicSpline,
    ramp: HermiteSpline,
    /// Contact that it was computed with.
    law: ContactLaw,
    finishing: Option<Finishing>,
    leaves_mm: f64,
    forecast: Option<Forecast>,
}

impl Correction {
    /// The exact correction of a part, and its proof: the path is ground again by the contact law, on a grid four times finer.
    ///
    /// # Errors
    /// A start before the log ends, a target above the least radius, a path that is not resolved by the state's phases.
    pub fn exact(
        state: &PartState<'_>,
        start: CorrectionStart,
        target: CorrectionTarget,
    ) -> Result<Self, CorrectionError> {
        let start_rad = start_of(state, start)?;
        let law = state.law();
        // Between phases as well, and at the start itself, which is what the turn ends on: else a place in between would not be cut.
        let places = state.phases() * PARTS as usize;
        let met = (0..=places).map(|place| state.radius_mm(start_rad + phase_rad(place, places) - TURN_RAD));
        let min_mm = met.fold(f64::INFINITY, f64::min);
        let target_mm = match target {
            CorrectionTarget::MinRadius { extra_depth_mm } if extra_depth_mm >= 0.0 && extra_depth_mm.is_finite() => {
                min_mm - extra_depth_mm
            }
            CorrectionTarget::MinRadius { extra_depth_mm } => {
                return Err(CorrectionError::ExtraDepth { extra_depth_mm });
            }
            CorrectionTarget::Radius(target_mm) if target_mm <= min_mm => target_mm,
            CorrectionTarget::Radius(target_mm) => {
                return Err(CorrectionError::TargetAboveMin { target_mm, min_mm });
            }
        };
        let (ratio, leaves_mm) =
            (law.grinding_n_mm() / law.machine_n_mm(), target_mm - law.threshold_n() / law.machine_n_mm());
        let wheel_mm = |c_rad: f64| leaves_mm - ratio * (state.radius_mm(c_rad - TURN_RAD) - target_mm);
        let ramp = ramp(wheel_mm(start_rad) - wheel_mm(start_rad + TURN_RAD))?;
        let count = state.phases();
        let path = (0..count).map(|index| {
            let since_rad = wrap_turn(phase_rad(index, count) - start_rad);
            wheel_mm(start_rad + since_rad) - ramp.sample(since_rad).value
        });
        let path = PeriodicSpline::interpolate(&path.collect::<Vec<f64>>())?;
        let (mode, finishing) = (GaugingMode::Exact, None);
        let mut correction = Self { mode, start_rad, path, ramp, law: *law, finishing, leaves_mm, forecast: None };
        let forecast = correction.ground(state);
        let allowed_mm = (LEFT_SHARE * forecast.before_mm).max(LEFT_MM).max(state.scatter_mm().unwrap_or(0.0));
        if forecast.left_mm > allowed_mm {
            return Err(CorrectionError::NotResolved { left_mm: forecast.left_mm, allowed_mm, phases: count });
        }
        correction.forecast = Some(forecast);
        Ok(correction)
    }

    /// The published correction: the wheel, at `wheel_mm` when measuring ended, is fed by ΔV = IR (1 + kg/km), from the first angle
    /// after `from_rad` on at which the phase of least IR stands at it.
    ///
    /// # Errors
    /// Numbers that are none.
    pub fn published(
        runout: &RadiusByPhase,
        law: &ContactLaw,
        wheel_mm: f64,
        from_rad: f64,
    ) -> Result<Self, CorrectionError> {
        if !(wheel_mm.is_finite() && from_rad.is_finite()) {
            return Err(CorrectionError::Wheel { wheel_mm });
        }
        let factor = 1.0 + law.grinding_n_mm() / law.machine_n_mm();
        let path: Vec<f64> = runout.runout_mm().iter().map(|ir_mm| wheel_mm - factor * ir_mm).collect();
        let start_rad = from_rad + wrap_turn(runout.phase_rad(runout.minimum_index()) - from_rad);
        let path = PeriodicSpline::interpolate(&path)?;
        Ok(Self {
            mode: GaugingMode::Published,
            start_rad,
            path,
            ramp: ramp(0.0)?,
            law: *law,
            finishing: None,
            leaves_mm: wheel_mm,
            forecast: None,
        })
    }

    /// With finishing turns after it, which end their depth below the radius of the correction; without, as it is.
    #[must_use]
    pub fn finished(self, finishing: Option<Finishing>, state: &PartState<'_>) -> Self {
        let Some(finishing) = finishing else { return self };
        let leaves_mm = self.leaves_mm - finishing.depth_mm;
        let finished = Self { finishing: Some(finishing), leaves_mm, ..self };
        let forecast = finished.forecast.map(|_| finished.ground(state));
        Self { forecast, ..finished }
    }

    /// Turns of the correction and of finishing.
    #[must_use]
    pub fn turns(&self) -> u32 {
        1 + self.finishing.map_or(0, |finishing| finishing.all_turns())
    }

    /// Which law made it.
    #[must_use]
    pub const fn mode(&self) -> GaugingMode {
        self.mode
    }

    /// Angle of the headstock at which the turn begins (rad).
    #[must_use]
    pub const fn start_rad(&self) -> f64 {
        self.start_rad
    }

    /// `x_axis` over C modulo a turn (mm over rad), the ramp apart: the path of a cut that begins at [`Correction::start_rad`] and takes one
    /// turn.
    #[must_use]
    pub const fn path(&self) -> &PeriodicSpline {
        &self.path
    }

    /// Addition to the path over the angle since the start (mm over rad); 0 at the end of the turn.
    #[must_use]
    pub const fn ramp(&self) -> &HermiteSpline {
        &self.ramp
    }

    /// Position at which the wheel may stay after the turn (mm). For an exact correction: the position at which it no longer cuts the new
    /// circle.
    #[must_use]
    pub const fn leaves_mm(&self) -> f64 {
        self.leaves_mm
    }

    /// Predicted result; `None` for a published correction, which cannot predict it.
    #[must_use]
    pub const fn forecast(&self) -> Option<&Forecast> {
        self.forecast.as_ref()
    }

    /// `x_axis` and its derivatives with respect to C (mm, rad), at an angle since the start over all [`Correction::turns`] (rad).
    #[must_use]
    pub fn at(&self, since_rad: f64) -> Sample {
        match self.finishing {
            Some(finishing) if since_rad > TURN_RAD => match self.mode {
                GaugingMode::Exact => {
                    let target_mm = self.leaves_mm + self.law.threshold_n() / self.law.machine_n_mm();
                    finishing.by_the_law(&self.law, target_mm, since_rad - TURN_RAD)
                }
                GaugingMode::Published => finishing.fed_from(self.leaves_mm + finishing.depth_mm, since_rad - TURN_RAD),
            },
            _ => self.correcting(since_rad),
        }
    }

    /// The same in the turn that corrects.
    fn correcting(&self, since_rad: f64) -> Sample {
        let (path, ramp) = (self.path.sample(self.start_rad + since_rad), self.ramp.sample(since_rad));
        Sample {
            value: path.value + ramp.value,
            first: path.first + ramp.first,
            second: path.second + ramp.second,
            third: path.third + ramp.third,
        }
    }

    /// Steepness over all turns, on a grid four times finer than its phases.
    #[must_use]
    pub fn steepness(&self) -> Steepness {
        let mut max = Steepness { first_mm_rad: 0.0, second_mm_rad2: 0.0, third_mm_rad3: 0.0 };
        let turns = (0..self.turns()).map(|turn| f64::from(turn) * TURN_RAD);
        for since_rad in turns.flat_map(|from_rad| self.places().map(move |place_rad| from_rad + place_rad)) {
            let sample = self.at(since_rad);
            max.first_mm_rad = max.first_mm_rad.max(sample.first.abs());
            max.second_mm_rad2 = max.second_mm_rad2.max(sample.second.abs());
            max.third_mm_rad3 = max.third_mm_rad3.max(sample.third.abs());
        }
        max
    }

    /// Places over the turn.
    fn places(&self) -> impl Iterator<Item = f64> {
        let count = self.path.coefficients().len() * PARTS as usize;
        (0..=count).map(move |place| phase_rad(place, count))
    }

    /// Radii of a part before the first turn, after it and after the last one (mm), at an angle since the start of 0 to 2π (rad).
    pub(super) fn radii_mm(&self, state: &PartState<'_>, since_rad: f64) -> [f64; 3] {
        let before_mm = state.radius_mm(self.start_rad + since_rad - TURN_RAD);
        let left_by = |radius_mm: f64, turn: u32| {
            let wheel_mm = self.at(since_rad + f64::from(turn) * TURN_RAD).value;
            state.law().radius_after_mm(radius_mm, wheel_mm)
        };
        let corrected_mm = left_by(before_mm, 0);
        [before_mm, corrected_mm, (1..self.turns()).fold(corrected_mm, left_by)]
    }

    /// Result according to the contact law.
    fn ground(&self, state: &PartState<'_>) -> Forecast {
        let (mut before, mut after, mut depth) = (ValueRange::EMPTY, ValueRange::EMPTY, ValueRange::EMPTY);
        for since_rad in self.places() {
            let [before_mm, corrected_mm, after_mm] = self.radii_mm(state, since_rad);
            before.add(before_mm);
            after.add(after_mm);
            depth.add(before_mm - corrected_mm);
        }
        Forecast {
            before_mm: before.max - before.min,
            radius_mm: after.min,
            left_mm: after.max - after.min,
            depth_mm: (depth.min, depth.max),
        }
    }
}

struct ValueRange {
    min: f64,
    max: f64,
}

impl ValueRange {
    const EMPTY: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn add(&mut self, value: f64) {
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }
}

/// From a difference to 0 over a turn. With neither slope nor curvature at its ends, so that it goes on smoothly before and after the
/// turn, as an infeed does; what of slope the path lacks to be periodic is nothing where the turn begins at the least radius.
fn ramp(difference_mm: f64) -> Result<HermiteSpline, HermiteError> {
    let knot = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
    HermiteSpline::new(Vec::from([knot(0.0, difference_mm), knot(TURN_RAD, 0.0)]))
}

/// C at which the turn begins.
fn start_of(state: &PartState<'_>, start: CorrectionStart) -> Result<f64, CorrectionError> {
    let (CorrectionStart::AtMinRadius { from_rad: wanted_rad } | CorrectionStart::At(wanted_rad)) = start;
    let logged_rad = state.logged_until_rad().unwrap_or(f64::NEG_INFINITY);
    if !(wanted_rad >= logged_rad && wanted_rad.is_finite()) {
        return Err(CorrectionError::BeforeLogEnds { start_rad: wanted_rad, logged_rad });
    }
    Ok(match start {
        CorrectionStart::At(start_rad) => start_rad,
        CorrectionStart::AtMinRadius { from_rad } => minimum_radius_from(state, from_rad),
    })
}

/// First C from an angle on at which a radius leaves the wheel that is the least of the turn before it, if possible at a place where it
/// has no slope.
fn minimum_radius_from(state: &PartState<'_>, from_rad: f64) -> f64 {
    let count = state.phases();
    let at = |place: usize| from_rad - TURN_RAD + phase_rad(place, count);
    let radii: Vec<f64> = (0..=2 * count + 1).map(|place| state.radius_mm(at(place))).collect();
    // Of a part that nothing is cut from, a turn before is the same but for rounding.
    let is_minimum = |place: &usize| radii[place - count..*place].iter().all(|radius| radii[*place] <= radius + 1e-12);
    let is_low = |place: &usize| radii[*place] <= radii[place - 1] && radii[*place] <= radii[place + 1];
    let Some(place) = (count..=2 * count).find(|place| is_low(place) && is_minimum(place)) else {
        // The part is rounder than a dwell turn is deep: every place is less than all before it.
        return (count..=2 * count).find(is_minimum).map_or(from_rad, at);
    };
    let step_rad = phase_rad(1, count);
    let (low_rad, _) = golden_section(at(place) - step_rad, at(place) + step_rad, &|c_rad| state.radius_mm(c_rad));
    low_rad.max(from_rad)
}
