// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From what was logged while a journal was ground to the way of the wheel that makes it round and to size.
//!
//! ```text
//! x  clear ──────────╮                              ╭────── clear
//!                     ╲ enters        ╭──╮         ╱ leaves
//!                      ╰───╮       ╭──╯  ╰────────╯
//!                          ╰───────╯
//!    C0: rests      C_s                   C_s + 2π            C0 + whole turns
//!       └ runs up ┘ └────── corrects ──────┘
//! ```
//! The wheel had left the part before C stopped, and comes back to it while C turns. What it cuts on entering is cut again at the end
//! of the turn: the way in is therefore fixed first, logged as if it had been driven, and the turn is computed with it. It ends where the
//! least radius leaves the wheel, so that the turn begins and ends alike.
//!
//! Size is the gauge's, not that of `x_axis`: where both disagree on the mean radius, the wheel stands elsewhere than its axis says, by
//! its wear or by the growth of a machine that has warmed up, and the turn is moved by as much.

use super::GaugingMode;
use super::correction::{
    Correction, CorrectionError, CorrectionStart, CorrectionTarget, Forecast, LEFT_MM, LEFT_SHARE,
};
use super::expected_runout::ExpectedRunout;
use super::finishing::{Finishing, FinishingError, FinishingSpec};
use super::fit::Fit;
use super::gauge::{Gauge, GaugeError};
use super::gauge_setup::{GaugeSetup, Readings};
use super::gauged_tick::{GaugedTick, turning_on};
use super::identify::IdentifyError;
use super::published::{PublishedError, PublishedRunout, PublishedWindow};
use super::record::{RecordError, RunoutReading};
use super::smallest_radius::{self, PLACES, SmallestRadius, place_rad};
use super::spark_out::{self, SparkOutError};
use super::state::{MeasureSettings, PartState, StateError};
use super::wheel_log::{WheelLog, WheelLogError, WheelPosition};
use crate::machine::contact_law::ContactLaw;
use crate::math::hermite::{HermiteError, HermiteSpline, Knot, Sample};
use crate::math::range::minimum_and_maximum;
use crate::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use alloc::vec::Vec;
use thiserror::Error;

/// Retraction from a part that still turns: start and end of the outward motion, before the end of the last turn of a dwell (rad). It is
/// long enough to leave a smooth surface, and ends before C slows down.
pub(crate) const DWELL_LEAVES_RAD: (f64, f64) = (TURN_RAD * 0.7, TURN_RAD * 0.1);
/// Angle that C has for coming to its speed and, at the end, to rest (rad).
const RUN_UP_RAD: f64 = TURN_RAD / 8.0;
/// Angle over which the wheel enters, and over which it leaves (rad). Where X moves by x' per angle, a wheel of radius R touches a journal
/// of radius r beside the line of centres and is x'² R/(2 r (r + R)) nearer to it than the law of a phase knows; so it enters slowly.
const ENTERS_RAD: f64 = TURN_RAD * 0.6;
const LEAVES_RAD: f64 = TURN_RAD * 0.25;
/// Clearance of the wheel from the largest radius before and after (mm).
const CLEAR_MM: f64 = 0.03;
/// Knots of the turn, and phases of the part that it is computed from.
const PHASES: u32 = 720;
/// Places at which the way in is logged.
const ENTRY_PLACES: u32 = 600;
/// Permitted depth of the wheel below the target after entry (mm): less than a gauge resolves.
const MAX_BELOW_MM: f64 = 1e-4;
/// Rounding tolerance between the last turn of readings and the end of its log (rad).
const ROUNDING_RAD: f64 = 1e-9;

/// End of the evaluated log before C rests (rad): the wheel has left by then, and C has hardly slowed down.
pub const LOG_ENDS_RAD: f64 = TURN_RAD / 36.0;

/// Returns the required part of a journal's log: from the last turn with infeed to the angle at which the wheel had left.
#[must_use]
pub fn needed_log(gauged: &[GaugedTick], rest_rad: f64, dwell_turns: u32) -> &[GaugedTick] {
    let from_rad = rest_rad - f64::from(dwell_turns + 1) * TURN_RAD;
    let from = gauged.partition_point(|gauged| gauged.c_rad < from_rad);
    let until = gauged.partition_point(|gauged| gauged.c_rad <= rest_rad - LOG_ENDS_RAD);
    gauged.get(from..until).unwrap_or_default()
}

/// Input for the correction of a journal.
#[derive(Debug, Clone, Copy)]
pub struct JournalRequest<'a> {
    /// Gauge that measures the journal.
    pub seen: GaugeSetup,
    /// The log: from a turn before the dwell on, or later, to where the wheel had left the part.
    pub gauged: &'a [GaugedTick],
    /// Contact law at the journal.
    pub law: ContactLaw,
    /// Standard uncertainty of km/kg of the law; `None` if it is not known.
    pub ratio_uncertainty: Option<f64>,
    /// Law of the correction.
    pub mode: GaugingMode,
    pub harmonics: u32,
    /// Window and step of the published measurement.
    pub published: PublishedWindow,
    /// Turns after the correction.
    pub finishing: Option<FinishingSpec>,
    /// Radius that the journal is to have (mm).
    pub radius_mm: f64,
    /// C where it rested after the log, counted as in the log (rad).
    pub rest_rad: f64,
}

impl JournalRequest<'_> {
    /// The law with km/kg larger by its standard uncertainty.
    fn with_another_ratio(&self) -> Option<ContactLaw> {
        let (machine_n_mm, grinding_n_mm) = (self.law.machine_n_mm(), self.law.grinding_n_mm());
        let ratio = machine_n_mm / grinding_n_mm + self.ratio_uncertainty?;
        ContactLaw::new(machine_n_mm, machine_n_mm / ratio, self.law.threshold_n()).ok()
    }
}

/// Why a journal cannot be corrected.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JournalError {
    /// Readings that are no record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Positions that are no log.
    #[error(transparent)]
    Log(#[from] WheelLogError),
    /// The readings do not determine the state of the part.
    #[error(transparent)]
    State(#[from] StateError),
    /// A part that cannot be corrected.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The finishing turns do not fit the contact.
    #[error(transparent)]
    Finishing(#[from] FinishingError),
    /// The published method and two gauges, or one that knows no size.
    #[error("the gauge reads no diameter; by the published method the depth of cut is the difference of two diameters")]
    NoDiameter,
    /// The log has turns of which nobody knows where they were put in.
    #[error("a hold put {turns} turns into its cut; it measures by turns that follow each other")]
    Held { turns: f64 },
    /// The journal was not seen all round.
    #[error("the gauge read {turned_deg:.1} deg of it, a whole turn is needed")]
    NotATurn {
        /// Angle of the readings (deg).
        turned_deg: f64,
    },
    /// A reading that is no number.
    #[error("the gauge gave no number at tick {tick}")]
    NoReading { tick: u64 },
    /// A required value is unknown.
    #[error("{what} is not known")]
    NotKnown { what: &'static str },
    /// The journal gives no stiffness.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The gauge gives no depth of cut.
    #[error(transparent)]
    Gauge(#[from] GaugeError),
    /// Readings are missing between two ticks.
    #[error("readings of the gauge are missing between tick {from} and tick {to}")]
    Lost {
        /// The last before the gap.
        from: u64,
        /// The first after it.
        to: u64,
    },
    /// A way that is none.
    #[error(transparent)]
    Way(#[from] HermiteError),
}

/// The correction of a journal: decided, and ready to be planned.
#[derive(Debug, Clone, PartialEq)]
pub struct JournalCorrection {
    /// Which law made it.
    pub mode: GaugingMode,
    /// `x_axis` (mm) over the angle since C began to turn (rad), over whole turns.
    pub way: HermiteSpline,
    pub turns: u32,
    /// Angle since C began to turn at which the correction begins (rad); it takes one turn, and finishing turns follow.
    pub corrects_from_rad: f64,
    /// Turns after the correction, as decided for this journal.
    pub finishing: Option<Finishing>,
    /// Size of the part minus the size by `x_axis`, measured by the gauge (mm); `None` if the gauge reads no size.
    pub size_offset_mm: Option<f64>,
    /// Runout before it (mm): of the part as the gauge knew it.
    pub before_mm: f64,
    /// Result of an exact correction by the contact law, as if everything were known exactly.
    pub forecast: Option<Forecast>,
    /// Runout after an exact correction, with what is not known exactly.
    pub expected: Option<ExpectedRunout>,
    /// Standard deviation of the readings about the contact law (mm).
    pub scatter_mm: Option<f64>,
    /// The first and the last tick that it was decided from.
    pub ticks: (u64, u64),
    /// Depth below the journal's radius that the way may reach (mm): what a correction may leave, and how far the wheel may be below its
    /// target where it has entered.
    pub allowed_below_mm: f64,
    law: ContactLaw,
    /// Radii of the part before it, by `x_axis`, from the place at the wheel on (mm).
    part_mm: Vec<f64>,
}

impl JournalCorrection {
    /// Smallest radius that a way of the wheel leaves of this journal, as the gauge reads it. `x` is `x_axis` over the angle since C began
    /// to turn, for as many turns as the correction has (mm over rad).
    #[must_use]
    pub fn lowest(&self, wheel_radius_mm: f64, x: impl Fn(f64) -> Sample) -> SmallestRadius {
        let lowest = smallest_radius::lowest(&self.law, &self.part_mm, self.turns, wheel_radius_mm, x);
        SmallestRadius { radius_mm: lowest.radius_mm + self.size_offset_mm.unwrap_or(0.0), ..lowest }
    }

    /// Largest radius of the part before it, by `x_axis` (mm).
    #[must_use]
    pub fn highest_before_mm(&self) -> f64 {
        self.part_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The contact that it was computed with.
    #[must_use]
    pub const fn law(&self) -> &ContactLaw {
        &self.law
    }

    /// Turns at constant wheel position, as one sparks out by habit, until the runout were as small as given (mm).
    ///
    /// # Errors
    /// A runout that is not above 0.
    pub fn spark_out_turns_to(&self, left_mm: f64) -> Result<f64, SparkOutError> {
        spark_out::turns(&self.law, self.before_mm, left_mm)
    }

    /// Expected correction before anything is measured: a turn around the journal's radius (mm), for a prediction of time and clearance.
    #[must_use]
    pub fn expected(mode: GaugingMode, radius_mm: f64, law: ContactLaw, finishing: Option<Finishing>) -> Self {
        let turns = 3 + finishing.map_or(0, |finishing| finishing.all_turns());
        let still = |at: f64| Knot { at, value: radius_mm + CLEAR_MM, first: 0.0, second: 0.0 };
        let way = HermiteSpline::new(Vec::from([still(0.0), still(f64::from(turns) * TURN_RAD)]));
        Self {
            mode,
            way: way.expect("two knots a turn and more apart"),
            turns,
            corrects_from_rad: TURN_RAD,
            finishing,
            size_offset_mm: None,
            before_mm: 0.0,
            forecast: None,
            expected: None,
            scatter_mm: None,
            ticks: (0, 0),
            allowed_below_mm: LEFT_MM,
            law,
            part_mm: alloc::vec![radius_mm; PLACES as usize],
        }
    }

    /// From the log of a journal that was fed, dwelled on and left.
    ///
    /// # Errors
    /// Readings are lost or do not determine the part, or the turn cannot make the part round and to size.
    pub fn decide(request: &JournalRequest<'_>) -> Result<Self, JournalError> {
        if let Some(pair) = request.gauged.windows(2).find(|pair| pair[1].tick != pair[0].tick + 1) {
            return Err(JournalError::Lost { from: pair[0].tick, to: pair[1].tick });
        }
        let finishing = request.finishing.map(|finishing| finishing.turns(&request.law)).transpose()?;
        let gauge = request.seen.gauge;
        let (readings, positions) = records(request);
        let record = readings.record(gauge)?;
        let readings = readings.first.as_slice();
        let settings = MeasureSettings {
            fit: Fit::Readings { harmonics: request.harmonics },
            phases: Some(PHASES as usize),
            ..MeasureSettings::default()
        };
        let state = PartState::measure(&record, WheelLog::new(&positions)?, request.law, &settings)?;
        let size_offset_mm = size_offset_mm(&gauge, readings, &state);
        let clear_mm = clear_mm(&state)?;
        let earliest_rad = request.rest_rad + RUN_UP_RAD + ENTERS_RAD;
        let (decided, begins, expected) = match request.mode {
            GaugingMode::Exact => {
                let depth_mm = finishing.map_or(0.0, |finishing| finishing.depth_mm);
                let target = CorrectionTarget::Radius(request.radius_mm + depth_mm - size_offset_mm.unwrap_or(0.0));
                let start = CorrectionStart::AtMinRadius { from_rad: earliest_rad };
                let first = Correction::exact(&state, start, target)?;
                let start_rad = first.start_rad();
                // At the least radius the turn begins without slope; noise must not make the wheel dip below it on its way in.
                let begins = Sample { value: first.at(0.0).value, ..Sample::default() };
                let logged = with_entry(&positions, start_rad, clear_mm, begins)?;
                let entered = PartState::measure(&record, WheelLog::new(&logged)?, request.law, &settings)?;
                let decided = match Correction::exact(&entered, CorrectionStart::At(start_rad), target) {
                    // On entering the wheel has already been at the target, but for rounding and the noise between two phases.
                    Err(CorrectionError::TargetAboveMin { target_mm, min_mm }) if target_mm - min_mm < MAX_BELOW_MM => {
                        Correction::exact(&entered, CorrectionStart::At(start_rad), CorrectionTarget::Radius(min_mm))?
                    }
                    other => other?,
                };
                let decided = decided.finished(finishing, &entered);
                let other = request.with_another_ratio().and_then(|law| {
                    let settings = MeasureSettings { max_scatter_mm: None, ..settings };
                    PartState::measure(&record, WheelLog::new(&logged).ok()?, law, &settings).ok()
                });
                let expected = ExpectedRunout::from_correction(&decided, &entered, other.as_ref());
                (decided, begins, Some(expected))
            }
            GaugingMode::Published => {
                if !gauge.fits_published() {
                    return Err(JournalError::NoDiameter);
                }
                let PublishedWindow { turned_rad, phases } = request.published;
                let turned_rad = turned_rad.unwrap_or_else(|| TURN_RAD + gauge.span_rad());
                let window_rad = record.end_rad() - turned_rad - ROUNDING_RAD;
                let read_rad = record.end_rad() - readings[0].c_rad;
                if read_rad < turned_rad {
                    let (turned_deg, needed_deg) = (deg_from_rad(read_rad), deg_from_rad(turned_rad));
                    return Err(PublishedError::WindowTooShort { turned_deg, needed_deg }.into());
                }
                let runout = PublishedRunout::measure(&record, &request.law, window_rad, phases as usize)?.runout;
                // Where the wheel stood while it was measured.
                let wheel_mm = positions.iter().map(|position| position.x_mm).fold(f64::INFINITY, f64::min);
                let decided = Correction::published(&runout, &request.law, wheel_mm, earliest_rad)?;
                // The slope and curvature of a turn through noisy phases, carried on over a way in of more than half a turn, would take
                // the wheel millimetres into the part: the way in is a step without either.
                let begins = Sample { value: decided.at(0.0).value, ..Sample::default() };
                (decided.finished(finishing, &state), begins, None)
            }
        };
        let before = state.radii_at(request.rest_rad)?;
        let (low, high) = minimum_and_maximum(before.radii_mm().iter().copied());
        let (way, turns) = whole_path(&decided, begins, request.rest_rad, clear_mm)?;
        // As each place last left the wheel.
        let left_at = |place| request.rest_rad + place_rad(place) - if place > 0 { TURN_RAD } else { 0.0 };
        let left_mm = (LEFT_SHARE * (high - low)).max(LEFT_MM).max(state.scatter_mm().unwrap_or(0.0));
        Ok(Self {
            mode: request.mode,
            way,
            turns,
            corrects_from_rad: decided.start_rad() - request.rest_rad,
            finishing,
            size_offset_mm,
            before_mm: high - low,
            forecast: decided.forecast().copied(),
            expected,
            scatter_mm: state.scatter_mm(),
            ticks: (readings[0].tick, readings[readings.len() - 1].tick),
            allowed_below_mm: left_mm + MAX_BELOW_MM,
            law: request.law,
            part_mm: (0..PLACES).map(|place| state.radius_mm(left_at(place))).collect(),
        })
    }
}

/// Readings that measured the cut, and the positions of the wheel.
fn records(request: &JournalRequest<'_>) -> (Readings, Vec<WheelPosition>) {
    // Of a wheel that is leaving, cuts end somewhere: they are followed by the law, not measured.
    let until_rad = request.rest_rad - DWELL_LEAVES_RAD.0 + request.seen.gauge.known_after_rad();
    let readings = request.seen.readings(request.gauged, until_rad);
    let position = |gauged: &GaugedTick| WheelPosition { c_rad: gauged.c_rad, x_mm: gauged.x_mm };
    (readings, turning_on(request.gauged).map(position).collect())
}

/// Size of the part minus the size by the wheel's positions and the contact law, as the mean of the last turn of readings of the first
/// gauge; `None` for a gauge that senses the part's deflection.
fn size_offset_mm(gauge: &Gauge, readings: &[RunoutReading], state: &PartState<'_>) -> Option<f64> {
    if gauge.feels_deflection() != 0.0 {
        return None;
    }
    let end_rad = readings[readings.len() - 1].c_rad;
    let contacts = gauge.contacts_rad(super::gauge::GaugeSide::First);
    let (mut sum, mut count) = (0.0, 0.0);
    for reading in readings.iter().filter(|reading| reading.c_rad > end_rad - TURN_RAD) {
        let (mut radii_mm, mut touched) = (0.0, 0.0);
        for behind_rad in contacts.iter().flatten() {
            radii_mm += state.radius_mm(reading.c_rad - behind_rad);
            touched += 1.0;
        }
        sum += (reading.value_mm - radii_mm) / touched;
        count += 1.0;
    }
    Some(sum / count)
}

/// Position at which the wheel is clear of the part (mm).
fn clear_mm(state: &PartState<'_>) -> Result<f64, StateError> {
    let end_rad = state.logged_until_rad().unwrap_or(0.0);
    let (_, high_mm) = minimum_and_maximum(state.radii_at(end_rad)?.radii_mm().iter().copied());
    Ok(high_mm + CLEAR_MM)
}

/// From clear of the part to where the turn begins.
fn entry(start_rad: f64, clear_mm: f64, begins: Sample) -> [Knot; 2] {
    [
        Knot { at: start_rad - ENTERS_RAD, value: clear_mm, first: 0.0, second: 0.0 },
        Knot { at: start_rad, value: begins.value, first: begins.first, second: begins.second },
    ]
}

/// The log, and the way in as if it had been driven.
fn with_entry(
    positions: &[WheelPosition],
    start_rad: f64,
    clear_mm: f64,
    begins: Sample,
) -> Result<Vec<WheelPosition>, HermiteError> {
    let law = HermiteSpline::new(Vec::from(entry(start_rad, clear_mm, begins)))?;
    let places = (0..=ENTRY_PLACES).map(|place| {
        let c_rad = start_rad - ENTERS_RAD * (1.0 - f64::from(place) / f64::from(ENTRY_PLACES));
        WheelPosition { c_rad, x_mm: law.sample(c_rad).value }
    });
    Ok(positions.iter().copied().chain(places).collect())
}

/// The way over whole turns from where C rests.
fn whole_path(
    turn: &Correction,
    begins: Sample,
    rest_rad: f64,
    clear_mm: f64,
) -> Result<(HermiteSpline, u32), HermiteError> {
    let start_rad = turn.start_rad() - rest_rad;
    let ends_rad = start_rad + f64::from(turn.turns()) * TURN_RAD + LEAVES_RAD;
    #[allow(clippy::cast_possible_truncation, reason = "a few turns")]
    let turns = libm::ceil((ends_rad + RUN_UP_RAD) / TURN_RAD) as u32;
    let still = |at: f64| Knot { at, value: clear_mm, first: 0.0, second: 0.0 };
    let last = turn.turns() * PHASES;
    let knot = |place: u32| {
        let since_rad = TURN_RAD * f64::from(place) / f64::from(PHASES);
        let at = match place {
            0 => begins,
            // From here on it takes nothing, and must not on its way out.
            _ if place == last => Sample { value: turn.leaves_mm(), ..Sample::default() },
            _ => turn.at(since_rad),
        };
        Knot { at: start_rad + since_rad, value: at.value, first: at.first, second: at.second }
    };
    let [enters, _] = entry(start_rad, clear_mm, begins);
    let knots = [still(0.0), enters]
        .into_iter()
        .chain((0..=last).map(knot))
        .chain([still(ends_rad), still(f64::from(turns) * TURN_RAD)]);
    Ok((HermiteSpline::new(knots.collect())?, turns))
}

impl core::fmt::Display for JournalCorrection {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let mode = match self.mode {
            GaugingMode::Exact => "exact",
            GaugingMode::Published => "published",
        };
        write!(f, "{mode} correction of {:.2} um", um_from_mm(self.before_mm))?;
        if let Some(expected) = &self.expected {
            write!(f, ": {expected}")?;
        }
        if let Some(offset_mm) = self.size_offset_mm {
            write!(f, ", the gauge reads {:+.2} um in radius against x_axis", um_from_mm(offset_mm))?;
        }
        // The published way knows no depth of a turn.
        if let (Some(finishing), GaugingMode::Exact) = (&self.finishing, self.mode) {
            let (turns, deepest_um) = (finishing.turns, um_from_mm(finishing.deepest_mm()));
            let s = if turns == 1 { "" } else { "s" };
            write!(
                f,
                ", {turns} finishing turn{s} of at most {deepest_um:.2} um and {:.1} N",
                finishing.peak_n(&self.law)
            )?;
        }
        let at_deg = deg_from_rad(self.corrects_from_rad);
        write!(f, ", begun {at_deg:.1} deg after C, decided from ticks {} to {}", self.ticks.0, self.ticks.1)
    }
}
