// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Least angles between insert and surface, all round a turn.

use super::prepared::PreparedTurning;
use camwright::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use camwright::toolpath::insert_clearance::Flank;
use camwright::toolpath::rake_section::{RakeSection, RakeSectionError};
use std::f64::consts::FRAC_PI_2;

/// Turned angles, and places along the part, at which clearances are looked at.
const ANGLES: u32 = 360;
const PLACES: u32 = 96;

/// The angles of insert and surface at one turned angle, each the least along the part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClearanceRow {
    pub(crate) turned_deg: f64,
    pub(crate) clearance: MinimumAngle,
    pub(crate) approach: MinimumAngle,
}

/// A least angle with its place, and the azimuth of the part that is cut there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MinimumAngle {
    pub(crate) angle_deg: f64,
    pub(crate) z_mm: f64,
    pub(crate) azimuth_deg: f64,
}

/// The least angles between insert and surface all round a turn.
pub(crate) fn clearance_rows(prepared: &PreparedTurning) -> Result<Vec<ClearanceRow>, RakeSectionError> {
    let Some(insert) = &prepared.machine.insert else { return Ok(Vec::new()) };
    let (relief_rad, spec) = (Flank::from_insert(insert).relief_rad, &prepared.job.spec);
    let (from_mm, to_mm) = spec.range_mm();
    let section = RakeSection::new(&spec.surface, insert.height_mm, from_mm, to_mm)?;
    let row = |angle: u32| {
        let turned_rad = TURN_RAD * f64::from(angle) / f64::from(ANGLES);
        let none = MinimumAngle { angle_deg: f64::INFINITY, z_mm: from_mm, azimuth_deg: 0.0 };
        let (mut clearance, mut approach) = (none, none);
        for place in 0..=PLACES {
            let z_mm = from_mm + (to_mm - from_mm) * f64::from(place) / f64::from(PLACES);
            let point = section.point(turned_rad, z_mm)?;
            let azimuth_deg = deg_from_rad(wrap_turn(turned_rad + point.lead_rad));
            let normal_rad = point.normal_rad();
            for (min, angle_rad) in [(&mut clearance, relief_rad - normal_rad), (&mut approach, FRAC_PI_2 + normal_rad)]
            {
                let angle_deg = deg_from_rad(angle_rad);
                if angle_deg < min.angle_deg {
                    *min = MinimumAngle { angle_deg, z_mm, azimuth_deg };
                }
            }
        }
        Ok(ClearanceRow { turned_deg: f64::from(angle) * 360.0 / f64::from(ANGLES), clearance, approach })
    };
    (0..ANGLES).map(row).collect()
}
