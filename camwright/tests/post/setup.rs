// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A shop with its control, and what it makes.

use crate::cams::reference_lobe;
use camwright::gcode::archimedean::Knots;
use camwright::gcode::post::{FeatureRequest, Lead, NcControl, PassRequest, PostRequest, ProgramTurnSpeed};
use camwright::gcode::{Dialect, Direction, NumberFormat, Tool, XValues};
use camwright::math::units::{rad_from_deg, rad_s_from_rpm};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};

/// The path of the axis of a cutter of a radius (mm) on the reference lobe.
pub(crate) fn lobe_path_of(radius_mm: f64) -> CutterPath {
    CutterPath::from_periphery(&reference_lobe(radius_mm))
}

/// A shop.
pub(crate) struct Shop {
    pub(crate) dialect: Dialect,
    pub(crate) format: NumberFormat,
    pub(crate) sense: i8,
    pub(crate) max_blocks_s: f64,
    pub(crate) rpm: f64,
}

impl Default for Shop {
    fn default() -> Self {
        let format = NumberFormat::new(4, 4, XValues::Radius).expect("a format");
        Self { dialect: Dialect::LinuxCnc, format, sense: 1, max_blocks_s: 500.0, rpm: 4.0 }
    }
}

impl Shop {
    /// One cam: roughed in three calls, finished in one.
    pub(crate) fn cam<'a>(&self, path: &'a CutterPath) -> PostRequest<'a> {
        let pass = |name: &str, leaves_mm: Vec<f64>, tolerance_mm: f64| PassRequest {
            name: name.into(),
            leaves_mm,
            tolerance_mm,
            widest_tolerance_mm: tolerance_mm,
            knots: Knots::Free,
            speed: ProgramTurnSpeed::WorkSpeed(rad_s_from_rpm(self.rpm)),
            turns: 1,
        };
        PostRequest {
            name: "lobe".into(),
            number: 1000,
            header: vec!["reference lobe".into()],
            tool: Tool { number: 1, radius_mm: 25.0, text: "end mill 50 mm".into() },
            spindle: Some((Direction::Clockwise, 800)),
            coolant: true,
            control: NcControl {
                dialect: self.dialect,
                format: self.format,
                max_blocks_s: self.max_blocks_s,
                path_tolerance_mm: Some(0.001),
                rotation_sense: self.sense,
            },
            features: vec![FeatureRequest {
                name: "A".into(),
                phase_rad: 0.0,
                path,
                stands_mm: vec![(CarriageAxis::Z, 20.0)],
                clear_mm: 60.0,
                lead: Lead { height_mm: 2.5, angle_rad: rad_from_deg(45.0), leaves_turning: true },
                passes: vec![pass("rough", vec![0.6, 0.3, 0.1], 0.01), pass("finish", vec![0.0], 0.0005)],
            }],
        }
    }
}
