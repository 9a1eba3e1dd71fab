// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A turn of a planned pass as a curve, for who draws it beside what became of it.

use super::PreparedJob;
use super::turn::LobeTurn;
use camwright::math::units::rpm_from_rad_s;

/// One point of a turn with its whole infeed, at the programmed speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnCurvePoint {
    /// Angle of `c_axis` (0 … 360).
    pub c_deg: f64,
    /// Speed of the headstock.
    pub c_rpm: f64,
    pub removal_mm2_s: f64,
}

/// The turn of a pass over a lobe, a tenth of a degree from point to point; none where the plan has no turn at the programmed speed.
#[must_use]
pub fn turn_curve(prepared: &PreparedJob, lobe: usize, pass: usize) -> Option<Vec<TurnCurvePoint>> {
    let turn = LobeTurn::new(prepared, lobe, pass)?;
    let point = |point: &super::turn::LobeTurnPoint| TurnCurvePoint {
        c_deg: point.c_deg,
        c_rpm: rpm_from_rad_s(point.c.first),
        removal_mm2_s: point.removal_mm2_s,
    };
    Some(turn.points.iter().map(point).collect())
}
