// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Position of a gauge, and its consequences: the phase and the cut that a reading belongs to, and the delay between them.
//!
//! Angles are those of the headstock, C, that grows while the part turns; a phase of the part is the C, modulo a turn, at which it
//! stands at the wheel. Seen along the rotation, a contact stands at γ after the wheel:
//!
//! ```text
//!              γ = 90°                 the contact at γ touches, at C, the phase C − γ
//!                │
//!   γ = 180° ─ (part) ◄ wheel, γ = 0   the part turns so that a phase comes from the wheel to γ = 90°
//!                │
//!              γ = 270°
//! ```
//! The method of measuring the actual depth of cut (JTEKT: method of measuring the actual depth of cut, machining method and machine
//! tool) takes two readings that touch the same phases, with exactly one cut between them. Two numbers say all about a geometry:
//!
//! | gauge | the same phases again after a span s of | the cut comes after δ of |
//! |---|---|---|
//! | two opposed contacts, one at γ | 180°, with the ends exchanged | −γ modulo 180° |
//! | a single radial probe at γ | 360° | 360° − γ |
//! | two such diameters, γ and γ + Φ | Φ | −γ modulo 180° |
//!
//! and then U of the cut at C is M(C − δ) − M′(C − δ + s), with M the reading before and M′ that after it. The patent draws the first
//! at γ = 270° and the third; its text never states the angle between spindle phase and contact, which is δ.

use crate::math::units::{TURN_RAD, deg_from_rad, rad_from_deg, wrap_turn};
use core::f64::consts::PI;
use thiserror::Error;

/// Minimum angle between a contact and the wheel line, and between two gauges and the cut between them (deg). The contact arc of wheel and
/// part is a millimetre or two long, 3° to 6° on a journal of 20 mm, and a tip within it is neither before nor after the cut; a closer
/// gauge cannot be distinguished from one at the wheel. A larger value would refuse a small tip on a large part.
pub const NEAREST_DEG: f64 = 1.0;

/// Reasons why a gauge cannot measure the depth of cut.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum GaugeError {
    /// The angle is no angle within a turn.
    #[error("contact at {angle_deg} deg after the wheel: must lie between 0 and 360 deg")]
    OutsideTurn {
        /// Given angle (deg).
        angle_deg: f64,
    },
    /// A contact stands at the wheel, or opposite it where its other end is.
    #[error(
        "contact at {angle_deg:.3} deg after the wheel is {distance_deg:.3} deg from the wheel line, at least {min_deg} deg are needed: \
         its reading belongs to no side of a cut"
    )]
    AtTheWheel {
        /// Angle of the gauge (deg).
        angle_deg: f64,
        /// Distance from the wheel line (deg).
        distance_deg: f64,
        /// Least allowed (deg).
        min_deg: f64,
    },
    /// Two gauges that are no part of half a turn apart.
    #[error("gauges {apart_deg} deg apart: must be more than 0 and less than 180 deg")]
    Apart {
        /// Given angle (deg).
        apart_deg: f64,
    },
    /// No cut lies between two gauges.
    #[error(
        "gauges at {angle_deg:.3} and {second_deg:.3} deg after the wheel have neither the wheel nor its opposite between them: the cut \
         comes {cut_after_deg:.3} deg after the first and must come {min_deg} deg before the second"
    )]
    NoCutBetween {
        /// The first (deg).
        angle_deg: f64,
        /// The second (deg).
        second_deg: f64,
        /// Way from the first to the cut (deg).
        cut_after_deg: f64,
        /// Least way from the cut to the second (deg).
        min_deg: f64,
    },
    /// Two gauges of a kind that the method does not know.
    #[error(
        "two gauges of one contact each: measure the depth of cut with one such gauge, or with two that read diameters"
    )]
    TwoProbes,
    /// The share of the part in the deflection is no share.
    #[error("share of the part in the deflection {work_share}: must lie between 0 and 1")]
    WorkShare { work_share: f64 },
    /// The difference of two zeros is no number.
    #[error("difference of the gauges' zeros {difference_mm} mm is not a finite number")]
    ZeroDifference {
        /// Given value (mm).
        difference_mm: f64,
    },
}

/// Which record of a gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GaugeSide {
    /// That of the only gauge, or of the first.
    First,
    /// That of the second.
    Second,
}

impl core::fmt::Display for GaugeSide {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            GaugeSide::First => "gauge",
            GaugeSide::Second => "second gauge",
        })
    }
}

/// Measured quantity of a gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
enum GaugeQuantity {
    Diameter,
    Radius { work_share: f64 },
    TwoDiameters { apart_rad: f64, zero_difference_mm: f64 },
}

/// Gauge that measures the depth of every cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge {
    angle_rad: f64,
    kind: GaugeQuantity,
}

impl Gauge {
    /// Two opposed contacts that read a diameter, one of them at `angle_rad` after the wheel. It reads the same wherever the part's
    /// axis is pushed along the line of its contacts, and to first order wherever it is pushed at all.
    ///
    /// # Errors
    /// An angle outside 0..2π, or within [`NEAREST_DEG`] of 0, 180 or 360°.
    pub fn diameter(angle_rad: f64) -> Result<Self, GaugeError> {
        clear_of_the_wheel(angle_rad, PI)?;
        Ok(Self { angle_rad, kind: GaugeQuantity::Diameter })
    }

    /// One contact that reads a radius from the machine's axis, at `angle_rad` after the wheel. Where the part deflects by T, it reads
    /// r − s·T·cos γ, with s the share that the part (not the wheelhead) has in T: nothing of it at 90 and 270°, all of it opposite the
    /// wheel. `work_share` is s, 0 to 1.
    ///
    /// # Errors
    /// An angle outside 0..2π, or within [`NEAREST_DEG`] of the wheel; a share that is none.
    pub fn radius(angle_rad: f64, work_share: f64) -> Result<Self, GaugeError> {
        clear_of_the_wheel(angle_rad, TURN_RAD)?;
        if !(0.0..=1.0).contains(&work_share) {
            return Err(GaugeError::WorkShare { work_share });
        }
        Ok(Self { angle_rad, kind: GaugeQuantity::Radius { work_share } })
    }

    /// Two gauges of opposed contacts, the second `apart_rad` after the first in the direction of rotation, with the wheel or its opposite
    /// between them: the depth is known earlier by 180° − Φ. `zero_difference_mm` is what the second reads more than the first on one
    /// master; it would be taken for a depth of cut.
    ///
    /// # Errors
    /// As [`Gauge::diameter`]; gauges not less than 180° apart, no cut between them, a difference that is no number.
    pub fn two_diameters(angle_rad: f64, apart_rad: f64, zero_difference_mm: f64) -> Result<Self, GaugeError> {
        clear_of_the_wheel(angle_rad, PI)?;
        if !(apart_rad > 0.0 && apart_rad < PI) {
            return Err(GaugeError::Apart { apart_deg: deg_from_rad(apart_rad) });
        }
        if !zero_difference_mm.is_finite() {
            return Err(GaugeError::ZeroDifference { difference_mm: zero_difference_mm });
        }
        let gauge = Self { angle_rad, kind: GaugeQuantity::TwoDiameters { apart_rad, zero_difference_mm } };
        if gauge.known_after_rad() < rad_from_deg(NEAREST_DEG) {
            return Err(GaugeError::NoCutBetween {
                angle_deg: deg_from_rad(angle_rad),
                second_deg: deg_from_rad(angle_rad + apart_rad),
                cut_after_deg: deg_from_rad(gauge.cut_after_rad()),
                min_deg: NEAREST_DEG,
            });
        }
        Ok(gauge)
    }

    /// γ of the contact, or of the first gauge's (rad).
    #[must_use]
    pub const fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Phases that it touches at an angle of the headstock, not wrapped into a turn (rad); the first gauge of two.
    #[must_use]
    pub fn touches_rad(&self, c_rad: f64) -> (f64, Option<f64>) {
        let first = c_rad - self.angle_rad;
        (first, (!matches!(self.kind, GaugeQuantity::Radius { .. })).then_some(first - PI))
    }

    /// δ: the angle from a reading to the cut that it is the reading before (rad).
    #[must_use]
    pub fn cut_after_rad(&self) -> f64 {
        match self.kind {
            GaugeQuantity::Radius { .. } => TURN_RAD - self.angle_rad,
            GaugeQuantity::Diameter | GaugeQuantity::TwoDiameters { .. } if self.angle_rad < PI => PI - self.angle_rad,
            GaugeQuantity::Diameter | GaugeQuantity::TwoDiameters { .. } => TURN_RAD - self.angle_rad,
        }
    }

    /// s: the angle from the reading before a cut to that after it (rad).
    #[must_use]
    pub const fn span_rad(&self) -> f64 {
        match self.kind {
            GaugeQuantity::Diameter => PI,
            GaugeQuantity::Radius { .. } => TURN_RAD,
            GaugeQuantity::TwoDiameters { apart_rad, .. } => apart_rad,
        }
    }

    /// Rotation of the part from a cut until its depth is known: s − δ (rad).
    #[must_use]
    pub fn known_after_rad(&self) -> f64 {
        self.span_rad() - self.cut_after_rad()
    }

    /// Angle of the headstock of the cut before which a reading at `c_rad` is taken; the phase that was cut is the same number modulo
    /// a turn (rad).
    #[must_use]
    pub fn cut_following_rad(&self, c_rad: f64) -> f64 {
        c_rad + self.cut_after_rad()
    }

    /// Angle of the headstock of the cut that the reading at `c_rad`, of the second gauge where there are two, is the one after (rad).
    #[must_use]
    pub fn cut_seen_rad(&self, c_rad: f64) -> f64 {
        c_rad - self.known_after_rad()
    }

    /// Returns whether it consists of two gauges with separate records.
    #[must_use]
    pub const fn is_two(&self) -> bool {
        matches!(self.kind, GaugeQuantity::TwoDiameters { .. })
    }

    /// The published method can take the difference of its readings for a depth of cut: it is one gauge, and a part that deflects changes
    /// nothing of what it reads.
    #[must_use]
    pub fn fits_published(&self) -> bool {
        !self.is_two() && self.feels_deflection() == 0.0
    }

    /// Angles after the wheel of the contacts of one gauge, within a turn (rad).
    pub(super) fn contacts_rad(&self, which: GaugeSide) -> [Option<f64>; 2] {
        let near = match (self.kind, which) {
            (GaugeQuantity::TwoDiameters { apart_rad, .. }, GaugeSide::Second) => wrap_turn(self.angle_rad + apart_rad),
            _ => self.angle_rad,
        };
        let opposite = !matches!(self.kind, GaugeQuantity::Radius { .. });
        [Some(near), opposite.then(|| wrap_turn(near + PI))]
    }

    /// Difference of the second gauge's reading from the first's on one master (mm).
    pub(super) const fn zero_difference_mm(&self) -> f64 {
        match self.kind {
            GaugeQuantity::TwoDiameters { zero_difference_mm, .. } => zero_difference_mm,
            GaugeQuantity::Diameter | GaugeQuantity::Radius { .. } => 0.0,
        }
    }

    /// Reduction of the reading against the radius per deflection T: s·cos γ.
    pub(super) fn feels_deflection(&self) -> f64 {
        match self.kind {
            GaugeQuantity::Radius { work_share } => {
                let share = work_share * libm::cos(self.angle_rad);
                // Of a right angle nothing is felt, but its cosine has some rounding left.
                if share.abs() < 1e-12 { 0.0 } else { share }
            }
            GaugeQuantity::Diameter | GaugeQuantity::TwoDiameters { .. } => 0.0,
        }
    }
}

/// Checks that a contact is clear of the wheel line and, every `period_rad`, of the position of its other end there.
fn clear_of_the_wheel(angle_rad: f64, period_rad: f64) -> Result<(), GaugeError> {
    let angle_deg = deg_from_rad(angle_rad);
    if !(0.0..=TURN_RAD).contains(&angle_rad) {
        return Err(GaugeError::OutsideTurn { angle_deg });
    }
    let beyond = angle_rad - period_rad * libm::floor(angle_rad / period_rad);
    let distance_deg = deg_from_rad(beyond.min(period_rad - beyond));
    if distance_deg < NEAREST_DEG {
        return Err(GaugeError::AtTheWheel { angle_deg, distance_deg, min_deg: NEAREST_DEG });
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "angles are rounded, and positions are exact by design")]
mod tests {
    use super::*;

    fn deg(rad: f64) -> f64 {
        libm::round(deg_from_rad(rad) * 1e9) / 1e9
    }

    /// A contact in the half turn before the wheel sees its own phase cut, one in the half turn after the wheel that of its opposite.
    #[test]
    fn exactly_one_end_of_a_diameter_is_cut_within_half_a_turn() {
        for (angle_deg, cut_after_deg) in [(90.0, 90.0), (135.0, 45.0), (225.0, 135.0), (270.0, 90.0), (315.0, 45.0)] {
            let gauge = Gauge::diameter(rad_from_deg(angle_deg)).unwrap();
            assert_eq!(deg(gauge.cut_after_rad()), cut_after_deg);
            assert_eq!(deg(gauge.span_rad()), 180.0);
            assert_eq!(deg(gauge.known_after_rad()), 180.0 - cut_after_deg);
            // At C = 0 the phase of the next cut is the one that an end touches.
            let (near, far) = gauge.touches_rad(0.0);
            let cut_deg = deg(wrap_turn(gauge.cut_following_rad(0.0)));
            let ends_deg = [near, far.unwrap()].map(|end| deg(wrap_turn(end)));
            assert!(ends_deg.contains(&cut_deg), "{angle_deg}: {cut_deg} {ends_deg:?}");
            assert_eq!(cut_deg == ends_deg[0], angle_deg > 180.0);
            assert_eq!(deg(gauge.cut_seen_rad(gauge.span_rad())), deg(gauge.cut_following_rad(0.0)));
        }
    }

    #[test]
    fn two_gauges_know_earlier_by_what_they_are_nearer_than_half_a_turn() {
        let one = Gauge::diameter(rad_from_deg(330.0)).unwrap();
        let two = Gauge::two_diameters(rad_from_deg(330.0), rad_from_deg(60.0), 0.0).unwrap();
        assert_eq!(two.cut_after_rad(), one.cut_after_rad());
        assert_eq!(deg(one.known_after_rad() - two.known_after_rad()), 120.0);
        let probe = Gauge::radius(rad_from_deg(90.0), 0.3).unwrap();
        assert_eq!((deg(probe.cut_after_rad()), deg(probe.span_rad())), (270.0, 360.0));
        assert_eq!(probe.touches_rad(1.0).1, None);
    }

    #[test]
    fn gauges_that_cannot_work_are_refused() {
        for angle_deg in [0.0, 180.0, 360.0, 0.5, 179.2, 359.5] {
            let refused = Gauge::diameter(rad_from_deg(angle_deg));
            assert!(matches!(refused, Err(GaugeError::AtTheWheel { .. })), "{angle_deg}: {refused:?}");
        }
        for angle_deg in [0.0, 360.0, 0.5] {
            assert!(matches!(Gauge::radius(rad_from_deg(angle_deg), 0.5), Err(GaugeError::AtTheWheel { .. })));
        }
        assert!(Gauge::radius(PI, 0.5).is_ok());
        for angle_rad in [-1.0, 7.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Gauge::diameter(angle_rad), Err(GaugeError::OutsideTurn { .. })));
        }
        let two = |angle_deg: f64, apart_deg: f64| {
            Gauge::two_diameters(rad_from_deg(angle_deg), rad_from_deg(apart_deg), 0.0)
        };
        for apart_deg in [0.0, 180.0, -30.0, f64::NAN] {
            assert!(matches!(two(270.0, apart_deg), Err(GaugeError::Apart { .. })));
        }
        // Neither the wheel nor its opposite lies between 200 and 260°.
        let refused = two(200.0, 60.0).unwrap_err();
        assert!(matches!(refused, GaugeError::NoCutBetween { .. }));
        assert_eq!(
            alloc::format!("{refused}"),
            "gauges at 200.000 and 260.000 deg after the wheel have neither the wheel nor its opposite between them: the cut comes 160.000 \
             deg after the first and must come 1 deg before the second"
        );
        assert!(two(170.0, 60.0).is_ok());
        for share in [-0.1, 1.1, f64::NAN] {
            assert!(matches!(Gauge::radius(1.0, share), Err(GaugeError::WorkShare { .. })));
        }
        assert!(matches!(Gauge::two_diameters(6.0, 1.0, f64::NAN), Err(GaugeError::ZeroDifference { .. })));
    }
}
