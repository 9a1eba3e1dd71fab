// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Home switches and index marks of simulated slides, by components of LinuxCNC.

use camwright::machine::description::{Axis, Homing, HomingKind, MachineDescription};
use camwright_files::hal_file::HalConfig;
use std::fmt::Write as _;

/// References of a slide that is homed at a switch or at an index mark.
#[derive(Debug)]
pub(crate) struct SimulatedReferences<'a> {
    /// Short name of the axis.
    name: &'static str,
    homing: &'a Homing,
    /// Units of the pins for one mm.
    scale: f64,
    start_mm: f64,
    hysteresis_mm: f64,
}

/// References of the slides with these short names.
pub(crate) fn simulated_references<'a>(
    names: [&'static str; 3],
    hal: &HalConfig,
    machine: &'a MachineDescription,
) -> Vec<SimulatedReferences<'a>> {
    let axes = names.into_iter().zip(Axis::ALL).filter_map(|(name, axis)| {
        let description = machine.axis(axis);
        let homing = description.homing.as_ref()?;
        Some(SimulatedReferences {
            name,
            homing,
            scale: hal.axes[axis.index()].scale,
            start_mm: description.power_up_position,
            hysteresis_mm: machine.switch_hysteresis_mm,
        })
    });
    axes.collect()
}

impl SimulatedReferences<'_> {
    fn has_switch(&self) -> bool {
        self.homing.kind().is_some_and(HomingKind::has_switch)
    }

    /// Components in the order of their execution: type and name.
    pub(crate) fn components(&self) -> Vec<(&'static str, String)> {
        let switch: &[_] = if self.has_switch() { &[("comp", "home")] } else { &[] };
        let marks: &[_] = if self.homing.use_index {
            &[("ddt", "speed"), ("sim_spindle", "index"), ("scale", "since-mark")]
        } else {
            &[]
        };
        let all = [&[("scale", "slide")], switch, marks].concat();
        all.into_iter().map(|(kind, part)| (kind, format!("{}-{part}", self.name))).collect()
    }

    /// Connects them to the drive.
    pub(crate) fn connect(&self, text: &mut String) {
        let Self { name, homing, scale, .. } = self;
        let mut line = |line: String| {
            // A string takes everything.
            let _infallible = writeln!(text, "{line}");
        };
        line(format!("net {name}-from-drive => {name}-slide.in"));
        line(format!("setp {name}-slide.gain {}", 1.0 / scale));
        line(format!("setp {name}-slide.offset {}", self.start_mm));
        line(format!("net {name}-of-slide {name}-slide.out"));
        if self.has_switch() {
            let (slide, threshold, half) = if homing.search_mm_s > 0.0 {
                ("in1", "in0", -0.5 * self.hysteresis_mm)
            } else {
                ("in0", "in1", 0.5 * self.hysteresis_mm)
            };
            line(format!("net {name}-of-slide => {name}-home.{slide}"));
            line(format!("setp {name}-home.{threshold} {}", homing.switch_mm + half));
            line(format!("setp {name}-home.hyst {}", self.hysteresis_mm));
        }
        if homing.use_index {
            line(format!("net {name}-of-slide => {name}-speed.in"));
            line(format!("net {name}-speed-now {name}-speed.out => {name}-index.velocity-cmd"));
            line(format!("setp {name}-index.scale {}", 1.0 / homing.index_pitch_mm));
            line(format!("net {name}-pitches {name}-index.position-fb => {name}-since-mark.in"));
            line(format!("setp {name}-since-mark.gain {}", homing.index_pitch_mm * scale));
        }
    }
}
