// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Radii that a way of the wheel leaves of a journal, followed by the contact law over the whole way: in, around and out.

use crate::machine::contact_law::ContactLaw;
use crate::math::hermite::Sample;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Places of the part per turn that are followed: four per phase of a correction.
pub(super) const PLACES: u32 = 2880;

/// The smallest radius that a way leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallestRadius {
    /// Radius (mm).
    pub radius_mm: f64,
    /// Angle since C began to turn (rad).
    pub angle_rad: f64,
}

/// Angle of a place of the part (rad).
pub(super) fn place_rad(place: u32) -> f64 {
    TURN_RAD * f64::from(place) / f64::from(PLACES)
}

/// Follows a way of whole turns. `radii_mm` are those of the part before it, from the place at the wheel on; `x` is the way over the angle
/// since C began to turn (mm over rad).
///
/// A wheel whose face, given way, moves by f' per angle touches a part of radius r beside the line of centres, and cuts it f'² R/(2 r (r + R))
/// deeper.
pub(super) fn lowest(
    law: &ContactLaw,
    radii_mm: &[f64],
    turns: u32,
    wheel_radius_mm: f64,
    x: impl Fn(f64) -> Sample,
) -> SmallestRadius {
    let mut radii: Vec<f64> = radii_mm.to_vec();
    let mut lowest = SmallestRadius { radius_mm: f64::INFINITY, angle_rad: 0.0 };
    let mut before_mm = x(0.0).value;
    for turn in 0..turns {
        for (radius_mm, place) in radii.iter_mut().zip(0..) {
            let angle_rad = f64::from(turn) * TURN_RAD + place_rad(place);
            let wheel_mm = x(angle_rad).value;
            *radius_mm = law.radius_after_mm(*radius_mm, wheel_mm);
            let face_mm = wheel_mm.max(*radius_mm);
            let slope = (face_mm - before_mm) / place_rad(1);
            let beside_mm = match wheel_mm < *radius_mm {
                true => slope * slope * wheel_radius_mm / (2.0 * *radius_mm * (*radius_mm + wheel_radius_mm)),
                false => 0.0,
            };
            if *radius_mm - beside_mm < lowest.radius_mm {
                lowest = SmallestRadius { radius_mm: *radius_mm - beside_mm, angle_rad };
            }
            before_mm = face_mm;
        }
    }
    lowest
}
