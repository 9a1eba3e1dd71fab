// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part by phase: what radius every phase has, from the depths of cut that the gauge saw and the wheel positions that were logged.
//!
//! A phase that was at r(C − 2π) meets the wheel at L(C) and leaves it at
//!
//! ```text
//!  r(C) = λ r(C − 2π) + (1 − λ)(L(C) + F0/km),   λ = kg/(kg + km).
//! ```
//! Of one such motion, q, that begins with a constant, everything is known but the start; the rest obeys r − q = λ of itself a turn
//! before, so that (r − q)·λ^(−C/2π) = g is periodic. It has no step where the wheel is just cutting, as the radii have, nor one where
//! the infeed ended, and a cut of its harmonics smooths nothing that is there. The depths are linear in it:
//!
//! ```text
//!  U(C) = r(C − 2π) − r(C) = U_q(C) + a(C) g(φ),   a(C) = (1 − λ) λ^((C − 2π)/2π)
//! ```
//! and so are readings; g is their least-squares answer ([`Fit`]). At constant L, in a dwell, that is `U_j` = `U_0` λ^j with one number `U_0`
//! per phase, but cuts with infeed count as well. Of one cut alone it is the published r = L + F0/km + (kg/km) U. After the last cut
//! that the gauge knows, every phase is followed by the contact law itself, with the wheel where it was logged, and staying where it
//! was last.
//!
//! What harmonics cannot show is a wheel that was moved abruptly while it cut: it leaves a step on the part that decays by λ a turn.

use super::fit::{self, Fit, FitErrors};
use super::record::GaugeRecord;
use super::reference_motion::{ROUNDING_RAD, ReferenceMotion};
use super::runout::{FEWEST_PHASES, RadiusByPhase, phase_rad};
pub use super::state_error::StateError;
use super::wheel_log::WheelLog;
use crate::machine::contact_law::ContactLaw;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};

/// Default number of harmonics. Noise of a reading enters a radius √2·kg/km-fold, spread over all harmonics alike; bending and clamping of a
/// part lie in the lowest. More harmonics follow a rougher part and pass more noise: 30 instead of 15 pass √2 times as much.
pub const USUAL_HARMONICS: u32 = 15;

/// Default depth (mm) below which a phase counts as not cut: the resolution of a usual gauge.
pub const USUAL_MIN_DEPTH_MM: f64 = 1e-4;

/// Default scatter of the readings (mm) above which they are rejected: ten times the noise of a usual gauge. A gauge that jumped, or a wheel
/// at another position than logged, exceeds it. A stiffness wrong by half does not, it scatters a dwell of three turns by 0.3 µm:
/// [`Decay`](super::decay::Decay) detects that.
pub const USUAL_MAX_SCATTER_MM: f64 = 2e-3;

/// Phases per harmonic kept, and 360 at least: the curve through them errs by 1e-6 of the highest. More resolve what is no harmonic, as
/// where a wheel left the part; a correction's path has that many knots.
pub const PHASES_PER_HARMONIC: usize = 24;

/// Most harmonics: a tip of a millimetre and a half bridges the waves of the hundredth on a journal of 25 mm radius.
pub const MAX_HARMONICS: u32 = 100;

/// Most phases: beyond it a record has hundreds of readings for every harmonic that matters.
pub const MAX_PHASES: usize = 7200;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasureSettings {
    /// Method that derives radii from readings.
    pub fit: Fit,
    /// Number of phases, the knots of a correction's path; `None`: as many as the harmonics need ([`PHASES_PER_HARMONIC`]), or, for a fit to
    /// depths, as the gauge reads in a turn.
    pub phases: Option<usize>,
    /// Cuts before this angle of the headstock are omitted (rad): where a dwell began, or the last fault ended.
    pub from_rad: Option<f64>,
    /// Depth (mm) that every phase must have lost at every cut. Where the wheel takes nothing, nothing is known.
    pub min_depth_mm: f64,
    /// Largest scatter of the readings about the contact law (mm), see [`PartState::scatter_mm`]; `None` takes any.
    pub max_scatter_mm: Option<f64>,
}

impl Default for MeasureSettings {
    fn default() -> Self {
        Self {
            fit: Fit::Readings { harmonics: USUAL_HARMONICS },
            phases: None,
            from_rad: None,
            min_depth_mm: USUAL_MIN_DEPTH_MM,
            max_scatter_mm: Some(USUAL_MAX_SCATTER_MM),
        }
    }
}

/// Source of the radii.
#[derive(Debug, Clone, PartialEq)]
enum Source {
    /// They are given; nothing has been cut since.
    Known(PeriodicSpline),
    /// From cuts between two angles.
    Measured {
        deviation: PeriodicSpline,
        /// C from which q is followed (rad).
        from_rad: f64,
        /// q before that (mm).
        base_mm: f64,
        /// C of the last cut that the gauge saw (rad).
        until_rad: f64,
        /// Standard deviation of a reading about the law, where there is more to it than unknowns (mm).
        scatter_mm: Option<f64>,
        errors: Option<FitErrors>,
    },
}

/// Every phase's radius, now and while the wheel stays where it is.
#[derive(Debug, Clone)]
pub struct PartState<'a> {
    law: ContactLaw,
    log: Option<WheelLog<'a>>,
    phases: usize,
    source: Source,
}

impl<'a> PartState<'a> {
    /// A part whose radii are known, with the wheel clear of it.
    ///
    /// # Errors
    /// Radii that make no curve.
    pub fn from_known_radii(radii: &RadiusByPhase, law: ContactLaw) -> Result<Self, StateError> {
        let spline = PeriodicSpline::interpolate(radii.radii_mm())?;
        Ok(Self { law, log: None, phases: radii.radii_mm().len(), source: Source::Known(spline) })
    }

    /// From a gauge's record and the wheel's log, whose angles are counted alike. Every phase must be cut in every turn from the first
    /// cut used to the last that the gauge saw; what comes after it in the log may leave the part.
    ///
    /// # Errors
    /// Less than a turn of depths, a log that ends before them, phases that do not fit, a phase that was not cut.
    pub fn measure(
        record: &GaugeRecord<'_>,
        log: WheelLog<'a>,
        law: ContactLaw,
        settings: &MeasureSettings,
    ) -> Result<Self, StateError> {
        let phases = phases_of(record, settings)?;
        // Of a probe that feels the part deflect, the cut at the moment of the reading matters too.
        let (feels, delay_rad) = (record.gauge().feels_deflection(), record.gauge().cut_after_rad());
        let lead_rad = if feels == 0.0 { 0.0 } else { delay_rad };
        let first_rad = record
            .first_cut_rad()
            .max(log.start_rad() + lead_rad)
            .max(settings.from_rad.map_or(f64::NEG_INFINITY, |from_rad| from_rad + lead_rad));
        let until_rad = record.last_cut_rad();
        let needed_rad = until_rad + if feels == 0.0 { 0.0 } else { TURN_RAD - delay_rad };
        if needed_rad > log.last().c_rad + ROUNDING_RAD {
            let (logged_deg, needed_deg) = (deg_from_rad(log.last().c_rad), deg_from_rad(needed_rad));
            return Err(StateError::LogTooShort { logged_deg, needed_deg });
        }
        let from_rad = first_rad - lead_rad;
        let known = ReferenceMotion::from(law, log, from_rad);
        if until_rad - first_rad < TURN_RAD * (1.0 - 1.0 / phases_as_number(phases)) - ROUNDING_RAD {
            return Err(StateError::LessThanATurn { known_deg: deg_from_rad((until_rad - first_rad).max(0.0)) });
        }
        let fitted = match settings.fit {
            Fit::Depths { harmonics } => fit::by_depths(record, &known, (first_rad, until_rad), phases, harmonics)?,
            Fit::Readings { harmonics } => fit::by_readings(record, &known, until_rad, phases, harmonics)?,
        };
        if let (Some(scatter_mm), Some(max_mm)) = (fitted.scatter_mm, settings.max_scatter_mm)
            && (scatter_mm.is_nan() || scatter_mm > max_mm)
        {
            return Err(StateError::Scatter { scatter_mm, max_mm });
        }
        for (index, deviation) in fitted.deviations.iter().enumerate() {
            let phase = phase_rad(index, phases);
            for c_rad in fit::cuts_of(phase, first_rad, until_rad) {
                let depth_mm = known.depth_mm(c_rad) + known.weight(c_rad) * deviation;
                if depth_mm < settings.min_depth_mm {
                    return Err(StateError::NotCut {
                        phase_deg: deg_from_rad(phase),
                        c_deg: deg_from_rad(c_rad),
                        depth_mm,
                        min_mm: settings.min_depth_mm,
                    });
                }
            }
        }
        let source = Source::Measured {
            deviation: PeriodicSpline::interpolate(&fitted.deviations)?,
            from_rad,
            base_mm: known.base_mm,
            until_rad,
            scatter_mm: fitted.scatter_mm,
            errors: fitted.errors,
        };
        Ok(Self { law, log: Some(log), phases, source })
    }

    #[must_use]
    pub const fn law(&self) -> &ContactLaw {
        &self.law
    }

    #[must_use]
    pub const fn phases(&self) -> usize {
        self.phases
    }

    /// Standard deviation (mm) of a reading about what the contact law makes of the others; nothing where depths were fitted and no phase
    /// was cut twice. The gauge's noise if all is well, more if kg/km is wrong or the part has more harmonics than were fitted.
    #[must_use]
    pub const fn scatter_mm(&self) -> Option<f64> {
        match &self.source {
            Source::Known(_) => None,
            Source::Measured { scatter_mm, .. } => *scatter_mm,
        }
    }

    /// Errors of g by the noise of the readings; `None` for radii that are known or fitted to depths.
    pub(super) const fn errors(&self) -> Option<&FitErrors> {
        match &self.source {
            Source::Measured { errors, .. } => errors.as_ref(),
            Source::Known(_) => None,
        }
    }

    /// The part with another g, larger by `by_mm` at every phase.
    pub(super) fn with_larger_deviation(&self, by_mm: f64) -> Self {
        let mut part = self.clone();
        if let Source::Measured { deviation, .. } = &mut part.source {
            let larger = deviation.coefficients().iter().map(|coefficient| coefficient + by_mm);
            *deviation = PeriodicSpline::from_coefficients(larger.collect()).expect("as many finite numbers as before");
        }
        part
    }

    /// Angle of the headstock from which on nothing is logged and the wheel is taken to stay; nothing where it is clear of the part.
    #[must_use]
    pub fn logged_until_rad(&self) -> Option<f64> {
        self.log.map(|log| log.last().c_rad)
    }

    /// Radius with which a phase leaves the wheel (mm), at an angle of the headstock: no earlier than a turn before the first cut used.
    #[must_use]
    pub fn radius_mm(&self, c_rad: f64) -> f64 {
        let (deviation, from_rad, base_mm, until_rad) = match &self.source {
            Source::Known(spline) => return spline.sample(wrap_turn(c_rad)).value,
            Source::Measured { deviation, from_rad, base_mm, until_rad, .. } => {
                (deviation, *from_rad, *base_mm, *until_rad)
            }
        };
        let Some(log) = self.log else { return base_mm };
        let beyond = libm::ceil((c_rad - until_rad - ROUNDING_RAD) / TURN_RAD).max(0.0);
        let seen_rad = c_rad - beyond * TURN_RAD;
        let known = ReferenceMotion { law: self.law, log, from_rad, base_mm };
        let mut radius_mm = known.radius_mm(seen_rad)
            + libm::pow(self.law.decay(), (seen_rad - from_rad) / TURN_RAD)
                * deviation.sample(wrap_turn(seen_rad)).value;
        let mut turn = 1.0;
        while turn <= beyond {
            radius_mm = self.law.radius_after_mm(radius_mm, log.x_mm(seen_rad + turn * TURN_RAD));
            turn += 1.0;
        }
        radius_mm
    }

    /// The part as it is when the headstock is at an angle: every phase as it last left the wheel.
    ///
    /// # Errors
    /// None but of numbers that are none.
    pub fn radii_at(&self, c_rad: f64) -> Result<RadiusByPhase, StateError> {
        let radii = (0..self.phases).map(|index| {
            let phase = phase_rad(index, self.phases);
            self.radius_mm(c_rad - wrap_turn(c_rad - phase))
        });
        Ok(RadiusByPhase::new(radii.collect())?)
    }
}

/// Phases of a measurement.
fn phases_of(record: &GaugeRecord<'_>, settings: &MeasureSettings) -> Result<usize, StateError> {
    let harmonics = settings.fit.harmonics();
    if harmonics > MAX_HARMONICS {
        return Err(StateError::Harmonics { harmonics, max: MAX_HARMONICS });
    }
    let min = (2 * harmonics as usize + 1).max(FEWEST_PHASES);
    #[allow(clippy::cast_possible_truncation, reason = "between 0 and MAX_PHASES + 1")]
    let by_readings = || libm::round(record.per_turn()).clamp(0.0, 2.0 * MAX_PHASES as f64) as usize;
    // A denser record is read at the positions of the phases.
    let phases = settings.phases.unwrap_or_else(|| match settings.fit {
        Fit::Depths { .. } => by_readings().min(MAX_PHASES),
        Fit::Readings { .. } => (PHASES_PER_HARMONIC * harmonics as usize).max(360),
    });
    if (min..=MAX_PHASES).contains(&phases) {
        return Ok(phases);
    }
    Err(StateError::Phases { phases, harmonics, min, max: MAX_PHASES })
}

fn phases_as_number(phases: usize) -> f64 {
    phases as f64
}
