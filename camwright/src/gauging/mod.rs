// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 5. In-process gauging and runout correction: what the wheel really took, what that says of the part, and the turn that makes it round.
//!
//! ```text
//! gauge ─► record ──┐                    ┌─► correction (exact)  ─► a turn of x_axis over C
//!  Gauge  Reading   ├─► state ─► phases ─┤
//!        wheel_log ─┤   PartState        └─► spark_out: turns that it saves
//!      contact law ─┘─► published (U, ΔU, IR) ─► correction (published)
//!                 ▲
//! stiffness, decay: km, kg, F0 and λ measured on the machine ─► stiffness_map: kept along the table
//! ```
//! The method is JTEKT's (method of measuring the actual depth of cut, machining method and machine tool): the depth of cut U at a phase is
//! the difference of two diameters. The wheel's force bends the part by (kg/km) U + F0/km, so U determines the radius itself. Two forms exist.
//! [`GaugingMode::Published`] follows the text literally. It corrects by ΔV = IR (1 + kg/km), which leaves −km/(kg + km) of the runout with its sign
//! reversed, because it overestimates the change of the cut: if the radius before the wheel is larger by IR, the motion already contains IR,
//! and IR·kg/km must be added. [`GaugingMode::Exact`] follows every phase through the contact law with the logged wheel position, and leaves only the
//! errors of the gauge.
//!
//! ```
//! use camwright::machine::contact_law::ContactLaw;
//! use camwright::gauging::correction::{Correction, CorrectionStart, CorrectionTarget};
//! use camwright::gauging::gauge::Gauge;
//! use camwright::gauging::record::{GaugeRecord, RunoutReading};
//! use camwright::gauging::state::{MeasureSettings, PartState};
//! use camwright::gauging::wheel_log::{WheelLog, WheelPosition};
//! use core::f64::consts::PI;
//!
//! // What the machine recorded: two turns of a dwell at 20 mm of a part that is eccentric by 10 um and 40 um above its end, read
//! // every degree by two opposed contacts, one 270 deg after the wheel. λ is 0.8, F0/km 1 um.
//! let law = ContactLaw::new(1.0e4, 4.0e4, 10.0)?;
//! let radius = |c: f64| 20.001 + libm::pow(0.8, c / (2.0 * PI)) * (0.04 + 0.01 * libm::cos(c));
//! let at = |i: u32| f64::from(i) * PI / 180.0;
//! let readings: Vec<RunoutReading> = (0..720)
//!     .map(|i| RunoutReading { c_rad: at(i), value_mm: radius(at(i) - 1.5 * PI) + radius(at(i) - 0.5 * PI), tick: i.into() })
//!     .collect();
//! let positions: Vec<WheelPosition> = (0..720).map(|i| WheelPosition { c_rad: at(i), x_mm: 20.0 }).collect();
//!
//! let record = GaugeRecord::from_one(Gauge::diameter(1.5 * PI)?, &readings)?;
//! let part = PartState::measure(&record, WheelLog::new(&positions)?, law, &MeasureSettings::default())?;
//! let start = CorrectionStart::AtMinRadius { from_rad: 4.0 * PI };
//! let correction = Correction::exact(&part, start, CorrectionTarget::MinRadius { extra_depth_mm: 0.0 })?;
//! let forecast = correction.forecast().expect("an exact correction has a forecast");
//! assert!(forecast.before_mm > 0.008 && forecast.left_mm < 1e-6);
//! assert!((correction.at(0.0).value - 20.0).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//! Everything here is a function of readings and positions; who collects them, and who turns a [`correction::Correction`] into a cut,
//! is elsewhere. Angles are those of the headstock and grow with time; a phase of the part is the angle, modulo a turn, at which it
//! stands at the wheel.

pub mod correction;
pub mod decay;
pub mod expected_runout;
pub mod finishing;
pub mod fit;
pub mod gauge;
pub mod gauge_setup;
pub mod gauged_tick;
mod harmonics;
pub mod identify;
pub mod journal;
pub mod published;
pub mod record;
mod reference_motion;
pub mod runout;
pub mod sensitivity;
pub mod smallest_radius;
pub mod spark_out;
pub mod state;
mod state_error;
pub mod stiffness;
pub mod stiffness_map;
pub mod wheel_log;

/// Method of measuring and correcting a runout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GaugingMode {
    /// Radii by phase, propagated with the logged wheel position; the exact one-turn law.
    #[default]
    Exact,
    /// The formulas and the measuring window of the published method, to the letter.
    Published,
}
