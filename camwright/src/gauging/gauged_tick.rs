// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One tick of the log of a journal: gauge readings with the positions of the axes.

/// Reading of the gauge and state of the axes at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugedTick {
    pub tick: u64,
    /// Angle of the headstock, growing from turn to turn (rad).
    pub c_rad: f64,
    /// Position of `x_axis` (mm).
    pub x_mm: f64,
    /// Reading of the gauge, or of the first of two (mm).
    pub value_mm: f64,
    /// Reading of the second of two gauges (mm).
    pub second_mm: Option<f64>,
    /// Force of the motor of `x_axis`, positive outwards (N).
    pub motor_n: f64,
}

/// Entries at which C is farther than ever before. Where C stands, or its encoder seems to, later entries are skipped.
pub(super) fn turning_on(gauged: &[GaugedTick]) -> impl Iterator<Item = &GaugedTick> {
    let mut farthest_rad = f64::NEG_INFINITY;
    gauged.iter().filter(move |gauged| {
        let on = gauged.c_rad > farthest_rad;
        farthest_rad = if on { gauged.c_rad } else { farthest_rad };
        on
    })
}
