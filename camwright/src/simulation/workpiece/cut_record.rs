// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Peak process values at every degree of a lobe: force, power, specific energy and temperature.
//!
//! The force is that of the contact law. The rest is taken from the cut itself, where it is known what grinding takes: the area that is
//! gone and the time in which the contact passed a degree give the removal rate Q′, the contact law the depth a, both the footprint speed
//! v = Q′/a; and with ω, the speed of the wheel line about the part, and β, the angle of the normal to it, the part's curvature κ at the
//! contact is that of 1 + κR = centre·ω/(v cos β) (`speed_plan::process`).

use super::WheelCentre;
use crate::machine::description::{GrindingProcess, MachineDescription, ReferenceCut};
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Recorded sectors of a turn.
pub const DEGREES: usize = 360;

/// A depth below which the wheel rubs (mm): rounding, not a chip.
const MIN_DEPTH_MM: f64 = 1e-6;

/// Removal at one degree of a lobe.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RemovalAtDegree {
    /// Largest power of the wheel's spindle per width (W/mm).
    pub power_w_mm: f64,
    /// Energy per removed volume in that moment (J/mm³).
    pub specific_energy_j_mm3: f64,
    /// Peak temperature relative to a cut at the burn limit.
    pub burn_index: f64,
}

crate::snapshot!(RemovalAtDegree { power_w_mm, specific_energy_j_mm3, burn_index } on {});

/// The contact on its way over a degree.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Passage {
    degree: usize,
    area_mm2: f64,
    time_s: f64,
    turned_rad: f64,
    depth_mm: f64,
    cos_beta: f64,
    centre_mm: f64,
}

crate::snapshot!(Passage { degree, area_mm2, time_s, turned_rad, depth_mm, cos_beta, centre_mm } on {} holds |passage| {
    passage.degree < DEGREES => "there is no such degree",
});

/// The record of a lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct CutRecord {
    process: Option<GrindingProcess>,
    wheel_speed_m_s: f64,
    /// Largest normal force (N), of the whole contact as the law has it.
    forces_n: Vec<f64>,
    /// None without data of the grinding process.
    degrees: Vec<RemovalAtDegree>,
    passage: Option<Passage>,
    /// Azimuth of the wheel line before (rad).
    line_rad: Option<f64>,
}

impl Snapshot for CutRecord {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        // How many degrees there are the description decides.
        let Self { process: _, wheel_speed_m_s: _, forces_n, degrees, passage, line_rad } = self;
        codec.field("forces_n", |codec| codec.numbers(forces_n))?;
        codec.field("degrees", |codec| degrees.as_mut_slice().snapshot(codec))?;
        codec.field("passage", |codec| passage.snapshot(codec))?;
        codec.field("line_rad", |codec| line_rad.snapshot(codec))
    }
}

/// The contact at one position of the wheel.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactSample {
    /// Azimuth on the part (rad).
    pub(super) azimuth_rad: f64,
    pub(super) area_mm2: f64,
    /// Depth of cut along the normal (mm).
    pub(super) depth_mm: f64,
    /// Normal force (N).
    pub(super) force_n: f64,
    /// Cosine of the angle between the normal and the line from the part's axis to the wheel's centre.
    pub(super) cos_beta: f64,
}

impl CutRecord {
    /// An empty one for a lobe on a machine; none where wheel and part do not deflect, since the law of that is what a cut is known by.
    pub(crate) fn from_description(description: &MachineDescription) -> Option<Self> {
        description.contact.as_ref()?;
        let process = description.process;
        let degrees = alloc::vec![RemovalAtDegree::default(); if process.is_some() { DEGREES } else { 0 }];
        let (forces_n, wheel_speed_m_s) = (alloc::vec![0.0; DEGREES], description.wheel.surface_speed_m_s);
        Some(Self { process, wheel_speed_m_s, forces_n, degrees, passage: None, line_rad: None })
    }

    /// Cuts from now on are those of a wheel with this surface speed (m/s).
    pub(crate) fn set_wheel_speed(&mut self, wheel_speed_m_s: f64) {
        self.leave();
        self.wheel_speed_m_s = wheel_speed_m_s;
    }

    /// Removal at every degree from the keyway on; empty without process data in the machine file.
    #[must_use]
    pub fn degrees(&self) -> &[RemovalAtDegree] {
        &self.degrees
    }

    /// Largest normal force on every degree from the keyway on (N), of the whole contact.
    #[must_use]
    pub fn forces_n(&self) -> &[f64] {
        &self.forces_n
    }

    pub(super) fn leave(&mut self) {
        // A passage that was not finished says nothing of its degree.
        (self.passage, self.line_rad) = (None, None);
    }

    /// The wheel stood here for a while (s).
    pub(super) fn note(&mut self, wheel: WheelCentre, contact: ContactSample, time_s: f64) {
        let turned_rad = self.line_rad.replace(wheel.azimuth_rad).map_or(0.0, |before| {
            let turned = (wheel.azimuth_rad - before).abs();
            turned.min((TURN_RAD - turned).abs())
        });
        let turns = contact.azimuth_rad / TURN_RAD;
        #[allow(clippy::cast_possible_truncation, reason = "a fraction of a turn times the count")]
        let degree = (((turns - libm::floor(turns)) * DEGREES as f64) as usize).min(DEGREES - 1);
        self.forces_n[degree] = self.forces_n[degree].max(contact.force_n);
        if self.passage.is_none_or(|passage| passage.degree != degree) {
            if let Some(passage) = self.passage.take() {
                self.finish(passage, wheel.radius_mm);
            }
            self.passage = Some(Passage { degree, ..Passage::default() });
        }
        if let Some(passage) = &mut self.passage {
            passage.area_mm2 += contact.area_mm2;
            passage.time_s += time_s;
            passage.turned_rad += turned_rad;
            passage.depth_mm = passage.depth_mm.max(contact.depth_mm);
            (passage.cos_beta, passage.centre_mm) = (contact.cos_beta, wheel.centre_mm);
        }
    }

    fn finish(&mut self, passage: Passage, wheel_radius_mm: f64) {
        let Some(process) = self.process else { return };
        let Passage { degree, area_mm2, time_s, turned_rad, depth_mm, cos_beta, centre_mm } = passage;
        if !(depth_mm > MIN_DEPTH_MM && area_mm2 > 0.0 && time_s > 0.0 && turned_rad > 0.0) {
            return;
        }
        let removal_mm2_s = area_mm2 / time_s;
        let omega = turned_rad / time_s;
        let cut = ReferenceCut::from_contact((removal_mm2_s, depth_mm), (wheel_radius_mm, centre_mm), cos_beta, omega);
        let power_w_mm = process.power_w_mm(removal_mm2_s, cut.contact_mm(), self.wheel_speed_m_s);
        let at = &mut self.degrees[degree];
        at.burn_index = at.burn_index.max(process.burn_index(&cut));
        if power_w_mm > at.power_w_mm {
            at.power_w_mm = power_w_mm;
            at.specific_energy_j_mm3 = power_w_mm / removal_mm2_s;
        }
    }
}
