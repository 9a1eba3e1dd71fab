// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! km, kg, F0 and λ of a journal from what was logged while it was ground at two feeds, dwelled on and pushed with a stopped wheel.
//!
//! Force is what the motor of `x_axis` gives above what it gives where the wheel moves the same way and touches nothing: friction, the
//! same in both, drops out. Of the grinding that is the first turn of infeed, which is in the air; of the push its beginning.

use super::decay::{Comparison, Decay, DecayError};
use super::gauge_setup::GaugeSetup;
use super::gauged_tick::{GaugedTick, turning_on};
use super::record::RecordError;
use super::stiffness::{
    FeedForce, ForcePoint, ForceReading, GrindingStiffness, MeasuredValue, StiffnessError,
    grinding_stiffness_of_one_feed, machine_stiffness, mean_of_turn, ratio,
};
use crate::machine::contact_law::ContactLaw;
use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;
use thiserror::Error;

/// Turns of every feed that are looked at, the last before the infeed ends.
const TURNS_OF_A_FEED: u32 = 2;
/// Distance between the end of the last one and the end of its infeed (rad): the infeed ends in a blend.
const BEFORE_THE_BLEND_RAD: f64 = TURN_RAD * 0.1;
/// Phases of the dwell that the decay is taken from.
const PHASES: usize = 360;
/// Share of a push that is in the air for certain, and share of its largest force from which on it presses for certain.
const AIR_SHARE: f64 = 0.2;
const PRESSING_SHARE: f64 = 0.2;
/// Points that a push is taken together to.
const PUSH_POINTS: usize = 40;
/// Relative speed tolerance for a tick to belong to a push.
const PUSH_SPEED_SHARE: f64 = 0.5;

/// A tick of a push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PushTick {
    pub tick: u64,
    /// Position of `x_axis` (mm).
    pub x_mm: f64,
    /// Force of its motor, positive outwards (N).
    pub motor_n: f64,
}

impl From<GaugedTick> for PushTick {
    fn from(gauged: GaugedTick) -> Self {
        Self { tick: gauged.tick, x_mm: gauged.x_mm, motor_n: gauged.motor_n }
    }
}

/// Input for the identification of a journal.
#[derive(Debug, Clone, Copy)]
pub struct IdentifyRequest<'a> {
    /// Gauge that measures the journal.
    pub seen: GaugeSetup,
    /// Readings during the grinding of the journal, with the motor's force.
    pub gauged: &'a [GaugedTick],
    /// C at the beginning of a turn of infeed in the air (rad).
    pub air_from_rad: f64,
    /// C at the end of the infeed of each pass (rad).
    pub infeed_ends_rad: &'a [f64],
    /// C from the beginning of the last dwell to where the wheel begins to leave (rad).
    pub dwell_rad: (f64, f64),
    /// Ticks in which the wheel did not turn.
    pub pushed: &'a [PushTick],
    /// Speed of the push (mm/s).
    pub push_speed_mm_s: f64,
    /// Coulomb's friction of `x_axis`, as its data say (N): by so much the motor's force may be off wherever the axis creeps.
    pub friction_n: f64,
}

/// Reasons why a journal gives no stiffness.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IdentifyError {
    /// Readings that are no record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Points that make no line.
    #[error("{what}: {source}")]
    Stiffness { what: &'static str, source: StiffnessError },
    /// The dwell gives no decay.
    #[error(transparent)]
    Decay(#[from] DecayError),
    /// The wheel was not seen to push.
    #[error("no push of the stopped wheel was logged: {ticks} ticks at its speed, {min} are needed")]
    NoPush { ticks: usize, min: usize },
}

/// A journal's contact, measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified {
    /// km (N/mm).
    pub machine_n_mm: MeasuredValue,
    /// kg and F0.
    pub grinding: GrindingStiffness,
    /// kg as published, from the last feed alone, with its bias.
    pub one_feed: FeedForce,
    /// km/kg by force and by the decay of the dwell.
    pub comparison: Comparison,
    /// The law that follows: km as measured, km/kg from both ways by their uncertainties, F0 as the grinding then has it.
    pub law: ContactLaw,
    /// Uncertainty of the law.
    pub known_to: Uncertainty,
}

/// Standard uncertainties of a law, and km/kg as it has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// km/kg.
    pub ratio: MeasuredValue,
    /// Uncertainty of km (N/mm).
    pub machine_n_mm: f64,
    /// Uncertainty of kg (N/mm): those of km and km/kg as independent.
    pub grinding_n_mm: f64,
    /// Uncertainty of F0 (N): the stiction of a creeping axis, and the error of kg at the mean depth of cut.
    pub threshold_n: f64,
}

impl Identified {
    /// From the log of a journal.
    ///
    /// # Errors
    /// Readings that are lost, forces that make no line, no push, a law that is none.
    pub fn from_log(request: &IdentifyRequest<'_>) -> Result<Self, IdentifyError> {
        let gauge = request.seen.gauge;
        let readings = request.seen.readings(request.gauged, f64::INFINITY);
        let record = readings.record(gauge)?;
        let force = |gauged: &GaugedTick| ForceReading { c_rad: gauged.c_rad, force_n: -gauged.motor_n };
        let forces: Vec<ForceReading> = turning_on(request.gauged).map(force).collect();
        let of = |what: &'static str| move |source| IdentifyError::Stiffness { what, source };
        let air_n =
            mean_of_turn(&record, &forces, request.air_from_rad + TURN_RAD).map_err(of("the turn in the air"))?.force_n;
        let mut points: Vec<ForcePoint> = Vec::new();
        for ends_rad in request.infeed_ends_rad {
            for turn in (0..TURNS_OF_A_FEED).rev() {
                let until_rad = ends_rad - BEFORE_THE_BLEND_RAD - f64::from(turn) * TURN_RAD;
                let point = mean_of_turn(&record, &forces, until_rad).map_err(of("a turn of infeed"))?;
                points.push(ForcePoint { force_n: point.force_n - air_n, ..point });
            }
        }
        let grinding = GrindingStiffness::from_feeds(&points).map_err(of("grinding at two feeds"))?;
        let grinding = with_friction(grinding, request.friction_n, &points);
        let machine_n_mm = machine_stiffness(&push(request)?).map_err(of("the push"))?;
        let last = points[points.len() - 1];
        let one_feed = grinding_stiffness_of_one_feed(last, grinding.threshold_n.value).map_err(of("the last feed"))?;
        let dwell = readings.until(request.dwell_rad.1 + gauge.known_after_rad());
        let decay = Decay::from_dwell(&dwell.record(gauge)?, request.dwell_rad.0, PHASES)?;
        let comparison = Comparison::from_measurements(ratio(machine_n_mm, grinding.grinding_n_mm), decay.ratio);
        let (law, known_to) =
            best_law(machine_n_mm, &comparison, &points, request.friction_n).map_err(of("the law"))?;
        Ok(Self { machine_n_mm, grinding, one_feed, comparison, law, known_to })
    }
}

/// Both ways to km/kg together, each as it deserves: the decay knows no friction, the force no creeping axis.
fn best_law(
    machine_n_mm: MeasuredValue,
    comparison: &Comparison,
    points: &[ForcePoint],
    friction_n: f64,
) -> Result<(ContactLaw, Uncertainty), StiffnessError> {
    let weight = |measured: MeasuredValue| 1.0 / (measured.uncertainty * measured.uncertainty).max(f64::MIN_POSITIVE);
    let (by_force, by_decay) = (weight(comparison.by_force), weight(comparison.by_decay));
    let ratio = (by_force * comparison.by_force.value + by_decay * comparison.by_decay.value) / (by_force + by_decay);
    let grinding_n_mm = machine_n_mm.value / ratio;
    let count = points.len() as f64;
    let threshold_n = points.iter().map(|point| point.force_n - grinding_n_mm * point.way_mm).sum::<f64>() / count;
    let law = ContactLaw::new(machine_n_mm.value, grinding_n_mm, threshold_n.max(0.0))?;
    let ratio = MeasuredValue { value: ratio, uncertainty: 1.0 / libm::sqrt(by_force + by_decay) };
    let shares = libm::hypot(ratio.uncertainty / ratio.value, machine_n_mm.uncertainty / machine_n_mm.value);
    let mean_mm = points.iter().map(|point| point.way_mm).sum::<f64>() / count;
    let known_to = Uncertainty {
        ratio,
        machine_n_mm: machine_n_mm.uncertainty,
        grinding_n_mm: grinding_n_mm * shares,
        threshold_n: libm::hypot(creeping_n(friction_n), grinding_n_mm * shares * mean_mm),
    };
    Ok((law, known_to))
}

/// Standard uncertainty of a force of an axis that creeps (N): it sticks and slips, and its friction is anything up to Coulomb's, to either
/// side, evenly distributed.
fn creeping_n(friction_n: f64) -> f64 {
    friction_n / libm::sqrt(3.0)
}

/// Adds the friction of a creeping axis to the uncertainty of the line.
fn with_friction(found: GrindingStiffness, friction_n: f64, points: &[ForcePoint]) -> GrindingStiffness {
    let (min_mm, max_mm) = minimum_and_maximum(points.iter().map(|point| point.way_mm));
    let range_mm = max_mm - min_mm;
    let friction_n = creeping_n(friction_n);
    let more = |measured: MeasuredValue, by: f64| MeasuredValue {
        uncertainty: libm::hypot(measured.uncertainty, by),
        ..measured
    };
    GrindingStiffness {
        grinding_n_mm: more(found.grinding_n_mm, friction_n / range_mm),
        threshold_n: more(found.threshold_n, friction_n),
    }
}

/// Force over travel where the stopped wheel pressed on its way in.
fn push(request: &IdentifyRequest<'_>) -> Result<Vec<ForcePoint>, IdentifyError> {
    let way_mm = request.push_speed_mm_s * request.seen.cycle_time_s;
    let belongs = |pair: &[PushTick]| {
        let inwards_mm = pair[0].x_mm - pair[1].x_mm;
        pair[1].tick == pair[0].tick + 1 && (inwards_mm - way_mm).abs() <= PUSH_SPEED_SHARE * way_mm
    };
    // The longest run of ticks at the speed of the push; encoders make single ones seem slower or faster.
    let (mut best, mut run, mut missed) = ((0, 0), (0, 0), 0_u32);
    for index in 1..request.pushed.len() {
        match belongs(&request.pushed[index - 1..=index]) {
            true => (run.1, missed) = (index + 1, 0),
            false if missed < 3 && run.1 > run.0 => missed += 1,
            false => (run, missed) = ((index, index), 0),
        }
        if run.1 - run.0 > best.1 - best.0 {
            best = run;
        }
    }
    let ticks = &request.pushed[best.0..best.1];
    let min = 10 * PUSH_POINTS;
    if ticks.len() < min {
        return Err(IdentifyError::NoPush { ticks: ticks.len(), min });
    }
    #[allow(clippy::cast_possible_truncation, reason = "a share")]
    let air = &ticks[..(ticks.len() as f64 * AIR_SHARE) as usize];
    let mean = |ticks: &[PushTick], of: fn(&PushTick) -> f64| ticks.iter().map(of).sum::<f64>() / ticks.len() as f64;
    let air_n = mean(air, |pushed| -pushed.motor_n);
    let together: Vec<ForcePoint> = ticks
        .chunks(ticks.len() / PUSH_POINTS)
        .map(|chunk| ForcePoint {
            way_mm: -mean(chunk, |pushed| pushed.x_mm),
            force_n: mean(chunk, |pushed| -pushed.motor_n) - air_n,
        })
        .collect();
    let max_n = together.iter().map(|point| point.force_n).fold(0.0, f64::max);
    // Until the axis starts to slow down it pushes; what is below a share of the force may still be the closing contact.
    Ok(together.into_iter().filter(|point| point.force_n >= PRESSING_SHARE * max_n).collect())
}

impl core::fmt::Display for Identified {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (km, kg, f0) = (self.machine_n_mm, self.grinding.grinding_n_mm, self.grinding.threshold_n);
        let (force, decay) = (self.comparison.by_force, self.comparison.by_decay);
        write!(
            f,
            "machine {:.3} +- {:.3} N/um, grinding {:.1} +- {:.1} N/um and {:.0} +- {:.0} N to begin ({:.1} N/um by one feed, {:.1} of it \
             by what it takes to begin), their ratio {:.4} +- {:.4} by force and {:.4} +- {:.4} by the decay of the dwell{}",
            km.value * 1e-3,
            km.uncertainty * 1e-3,
            kg.value * 1e-3,
            kg.uncertainty * 1e-3,
            f0.value,
            f0.uncertainty,
            self.one_feed.grinding_n_mm * 1e-3,
            self.one_feed.bias_n_mm * 1e-3,
            force.value,
            force.uncertainty,
            decay.value,
            decay.uncertainty,
            if self.comparison.agrees(3.0) { "" } else { ": THEY DISAGREE" },
        )
    }
}
