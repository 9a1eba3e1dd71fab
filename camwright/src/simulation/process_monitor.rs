// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Live process values for viewers: power, normal force and burn index of the contact, computed from tick reports.
//!
//! As in the record of a lobe, the contact is averaged over a degree of C. The contact law gives the depth from the normal force, and the
//! motion of wheel and part gives the direction of the normal: tan β = Ẋ/(ω·centre), since the wheel slides along the contour.

use crate::machine::contact::ContactDescription;
use crate::machine::description::{Axis, GrindingProcess, MachineDescription, ReferenceCut, WheelDescription};
use crate::simulation::tick_report::TickReport;

/// Turn of C over which the contact is averaged (rad).
const DEGREE: f64 = core::f64::consts::PI / 180.0;
/// A depth below which the wheel rubs (mm).
const MIN_DEPTH_MM: f64 = 1e-6;

/// Process values since the last call of [`ProcessMonitor::take`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProcessValues {
    /// Largest normal force of the wheel (N).
    pub normal_force_n: f64,
    /// Power of the wheel spindle for the cut (W), and largest temperature relative to the burn limit; `None` without process data.
    pub heat: Option<Heat>,
}

/// Power and temperature of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Heat {
    pub power_w: f64,
    pub burn_index: f64,
}

/// The wheel in front of a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Engaged {
    /// Radius of the wheel (mm).
    pub wheel_radius_mm: f64,
    /// Width of the lobe (mm).
    pub lobe_width_mm: f64,
}

/// Sums over a degree of C.
#[derive(Debug, Clone, Copy, Default)]
struct Passage {
    area_mm2: f64,
    force_n: f64,
    time_s: f64,
    turned_rad: f64,
    infeed_mm: f64,
}

/// Computes process values from tick reports.
#[derive(Debug, Clone)]
pub struct ProcessMonitor {
    contact: ContactDescription,
    process: Option<GrindingProcess>,
    wheel_width_mm: f64,
    wheel_speed_m_s: f64,
    cycle_time_s: f64,
    passage: Passage,
    /// Values of the last degree, and whether it lies before the last call of `take`.
    last: Heat,
    is_old: bool,
    force_n: f64,
}

impl ProcessMonitor {
    /// Monitor of a machine; none for a machine whose contact is rigid, because its force and depth are unknown.
    #[must_use]
    pub fn new(machine: &MachineDescription) -> Option<Self> {
        Some(Self {
            contact: machine.contact.clone()?,
            process: machine.process,
            wheel_width_mm: machine.wheel.width_mm,
            wheel_speed_m_s: machine.wheel.surface_speed_m_s,
            cycle_time_s: machine.cycle_time_s(),
            passage: Passage::default(),
            last: Heat::default(),
            is_old: false,
            force_n: 0.0,
        })
    }

    /// Another wheel is mounted.
    pub fn mount(&mut self, wheel: &WheelDescription) {
        (self.wheel_width_mm, self.wheel_speed_m_s) = (wheel.width_mm, wheel.surface_speed_m_s);
        self.passage = Passage::default();
    }

    /// Adds a tick. `engaged` is `None` without a lobe in front of the wheel.
    pub fn add(&mut self, report: &TickReport, engaged: Option<Engaged>) {
        self.force_n = self.force_n.max(report.normal_force_n);
        let [c, x] = [Axis::C, Axis::X].map(|axis| report.axes[axis.index()]);
        let passage = &mut self.passage;
        passage.area_mm2 += report.removal.area_mm2;
        passage.force_n += report.normal_force_n * self.cycle_time_s;
        passage.time_s += self.cycle_time_s;
        passage.turned_rad += c.velocity.abs() * self.cycle_time_s;
        passage.infeed_mm += x.velocity * self.cycle_time_s;
        let Some(engaged) = engaged.filter(|_| report.normal_force_n > 0.0) else {
            (self.passage, self.last) = (Passage::default(), if self.is_old { Heat::default() } else { self.last });
            return;
        };
        if passage.turned_rad >= DEGREE {
            let passage = core::mem::take(&mut self.passage);
            let heat = self.heat(passage, report, engaged).unwrap_or_default();
            self.last = match self.is_old {
                true => heat,
                false => Heat {
                    power_w: self.last.power_w.max(heat.power_w),
                    burn_index: self.last.burn_index.max(heat.burn_index),
                },
            };
            self.is_old = false;
        }
    }

    fn heat(&self, passage: Passage, report: &TickReport, engaged: Engaged) -> Option<Heat> {
        let process = self.process.as_ref()?;
        let width_mm = engaged.lobe_width_mm.min(self.wheel_width_mm);
        let law = self.contact.law(report.axes[Axis::Z.index()].position, width_mm)?;
        let depth_mm = law.depth_from_force_mm(passage.force_n / passage.time_s);
        if !(depth_mm > MIN_DEPTH_MM && passage.area_mm2 > 0.0) {
            return None;
        }
        let centre_mm = report.axes[Axis::X.index()].position + engaged.wheel_radius_mm;
        let slope = passage.infeed_mm / (passage.turned_rad * centre_mm);
        let removal_mm2_s = passage.area_mm2 / passage.time_s;
        let cut = ReferenceCut::from_contact(
            (removal_mm2_s, depth_mm),
            (engaged.wheel_radius_mm, centre_mm),
            1.0 / libm::sqrt(1.0 + slope * slope),
            passage.turned_rad / passage.time_s,
        );
        let power_w_mm = process.power_w_mm(removal_mm2_s, cut.contact_mm(), self.wheel_speed_m_s);
        Some(Heat { power_w: power_w_mm * width_mm, burn_index: process.burn_index(&cut) })
    }

    /// Returns the values since the last call.
    pub fn take(&mut self) -> ProcessValues {
        self.is_old = true;
        ProcessValues {
            normal_force_n: core::mem::take(&mut self.force_n),
            heat: self.process.is_some().then_some(self.last),
        }
    }
}
