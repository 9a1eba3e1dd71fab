// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes in their nominal form and what they are off, for viewers: `~/lobe_forms`, and drawn, `~/markers`.

use super::lock;
use camwright::cam::form_tolerance::LobeZone;
use camwright::machine::description::MachineDescription;
use camwright::math::units::{TURN_RAD, um_from_mm, wrap_turn};
use camwright::planner::LobeDesign;
use camwright_files::convert::{centre_values, m_from_mm, mm_from_m};
use camwright_msgs::camwright_msgs::msg::{LobeForm, PartLobe};
use camwright_msgs::visualization_msgs::msg::{Marker, MarkerArray};
use camwright_planning::{AnyPrepared, PreparedJob, measured_form};
use camwright_ros::running::NodeError;
use camwright_ros::{Node, Publisher, Qos, RosError};
use camwright_scene::{self as scene, Frames, MarkerPose, Rgba};
use std::sync::Mutex;

/// Azimuths of a form: half a degree.
const AZIMUTHS: usize = 720;
/// Messages that a late viewer still gets: design and form of every lobe.
const DEPTH: u32 = 64;
/// Magnification of a drawn error: the tolerance is then as wide as a pencil line is long.
const MAGNIFICATION: f64 = 1000.0;

const DESIGN: Rgba = [0.10, 0.75, 0.95, 1.0];
const DESIGN_WIDTH: f64 = 0.0003;
const ERROR_WIDTH: f64 = 0.0006;
const LETTERS: f64 = 0.008;

/// The publishers, and what is drawn.
#[derive(Debug)]
pub(super) struct LobeForms {
    node: Node,
    forms: Publisher<LobeForm>,
    markers: Publisher<MarkerArray>,
    /// Lobes of the part that is drawn.
    drawn: Mutex<usize>,
}

impl LobeForms {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        Ok(Self {
            node: node.clone(),
            forms: node.publisher("~/lobe_forms", &Qos::latched(DEPTH))?,
            markers: node.publisher("~/markers", &Qos::latched(DEPTH))?,
            drawn: Mutex::default(),
        })
    }

    /// A job begins: its lobes in their nominal form, in the place of those before.
    pub(super) fn designed(&self, prepared: &AnyPrepared) {
        let AnyPrepared::Ground(prepared) = prepared else { return };
        let outcome = self.clear(&prepared.machine).and_then(|()| {
            let mut lobes = prepared.finished_lobes();
            lobes.try_for_each(|(index, lobe)| self.publish(prepared, index, &lobe.design, None))
        });
        self.log_failure(outcome);
    }

    /// A lobe has been ground.
    pub(super) fn ground(&self, prepared: &PreparedJob, index: usize, measured: &PartLobe) {
        let Some(lobe) = prepared.planned.lobes.get(index) else { return };
        self.log_failure(self.publish(prepared, index, &lobe.design, Some(measured)));
    }

    fn publish(
        &self,
        prepared: &PreparedJob,
        index: usize,
        design: &LobeDesign,
        measured: Option<&PartLobe>,
    ) -> Result<(), NodeError> {
        let form = form(&prepared.job.spec.name, &prepared.machine, design, measured);
        let frames = scene::frames_of(&self.node, &prepared.machine)?;
        let id = i32::try_from(index).unwrap_or(i32::MAX);
        self.markers.publish(&MarkerArray { markers: drawn(&form, &frames, id) })?;
        self.forms.publish(&LobeForm { header: frames.part_header(self.node.now()), ..form })?;
        let mut drawn = lock(&self.drawn);
        *drawn = (*drawn).max(index + 1);
        Ok(())
    }

    fn clear(&self, machine: &MachineDescription) -> Result<(), NodeError> {
        let ids = 0..i32::try_from(std::mem::take(&mut *lock(&self.drawn))).unwrap_or(i32::MAX);
        let frames = scene::frames_of(&self.node, machine)?;
        let of_lobe = |id| ["design", "form_error", "form_error_text"].map(|ns| scene::gone(place(&frames, ns, id)));
        let markers: Vec<Marker> = ids.flat_map(of_lobe).collect();
        if !markers.is_empty() {
            self.markers.publish(&MarkerArray { markers })?;
        }
        Ok(())
    }

    fn log_failure(&self, outcome: Result<(), NodeError>) {
        if let Err(error) = outcome {
            self.node.logger().warn(&format!("the markers for viewers cannot be published: {error}"));
        }
    }
}

fn place<'a>(frames: &'a Frames, ns: &'a str, id: i32) -> MarkerPose<'a> {
    MarkerPose { frame: if ns == "form_error_text" { &frames.table } else { &frames.part }, ns, id }
}

/// The design, and where the lobe has been measured what it is off there.
fn form(job: &str, machine: &MachineDescription, design: &LobeDesign, measured: Option<&PartLobe>) -> LobeForm {
    let azimuth = |index: usize| index as f64 * TURN_RAD / AZIMUTHS as f64;
    let phase_rad = measured.map_or(design.phase_rad, |part| design.phase_on_rad(part.key_way));
    let sign = design.contour.radius_sign();
    let contour = (0..AZIMUTHS).map(|i| sign * m_from_mm(design.contour.radius_at(azimuth(i) - phase_rad))).collect();
    let allowed_mm = |cam_azimuth_rad: f64| {
        let contour = &design.contour;
        design.tolerance.allowed_mm(LobeZone::at(contour, contour.cam_angle_at(cam_azimuth_rad)))
    };
    let form = measured.and_then(|part| Some(measured_form(design, part).ok()?.0));
    let form_error =
        form.as_ref().map(|form| largest_of(&form.deviations_mm, AZIMUTHS).into_iter().map(m_from_mm).collect());
    let pin = form.and_then(|form| form.pin(&design.contour, phase_rad));
    LobeForm {
        job: job.to_owned(),
        name: design.name.clone(),
        station: design.station.clone(),
        table_position: design.z_mm(machine).map_or(0.0, m_from_mm),
        width: m_from_mm(design.width_mm),
        tolerance: m_from_mm(design.tolerance.largest_mm()),
        form_error_allowed: (0..AZIMUTHS).map(|i| m_from_mm(allowed_mm(azimuth(i) - phase_rad))).collect(),
        contour,
        form_error: form_error.unwrap_or_default(),
        centre: centre_values(design.centre_on(measured.map_or(design.part_phase_rad, |part| part.key_way))),
        measured_radius: pin
            .iter()
            .map(|pin| m_from_mm(design.contour.base_radius_mm() + pin.radius_error_mm))
            .collect(),
        measured_centre: pin
            .map_or_else(Vec::new, |pin| vec![m_from_mm(pin.throw_mm), wrap_turn(phase_rad + pin.angle_error_rad)]),
        roundness: pin.iter().map(|pin| m_from_mm(pin.roundness_mm)).collect(),
        ..LobeForm::default()
    }
}

/// Value of the largest magnitude in each of `count` intervals, so that no extreme is lost.
fn largest_of(values: &[f64], count: usize) -> Vec<f64> {
    let stretch =
        |i: usize| &values[i * values.len() / count..((i + 1) * values.len() / count).max(i + 1).min(values.len())];
    if values.len() <= count {
        return values.to_vec();
    }
    (0..count).filter_map(|i| stretch(i).iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))).collect()
}

/// A form as markers: the design's edges, and in the middle of the lobe what it is off.
fn drawn(form: &LobeForm, frames: &Frames, id: i32) -> Vec<Marker> {
    let (z, half) = (form.table_position, 0.5 * form.width);
    let design = scene::rings(place(frames, "design", id), &form.contour, [z - half, z + half], DESIGN_WIDTH, DESIGN);
    let mut markers = vec![scene::about(design, &form.centre)];
    if form.form_error.is_empty() {
        return markers;
    }
    let scale = [MAGNIFICATION, form.tolerance];
    let ring = place(frames, "form_error", id);
    let ring = scene::error_ring(ring, &form.contour, &form.form_error, z, scale, ERROR_WIDTH);
    markers.push(scene::about(ring, &form.centre));
    let um = |error: f64| um_from_mm(mm_from_m(error));
    let (low, high) = form.form_error.iter().fold((0.0_f64, 0.0_f64), |(low, high), e| (low.min(*e), high.max(*e)));
    let text = format!("{}: {:+.2} to {:+.2} um, drawn x {MAGNIFICATION}", form.name, um(low), um(high));
    let throw = form.centre.first().copied().unwrap_or_default();
    let below = throw + form.contour.iter().map(|radius| radius.abs()).fold(0.0, f64::max) + 2.0 * LETTERS;
    markers.push(scene::text(place(frames, "form_error_text", id), [0.0, -below, z], LETTERS, text));
    markers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_extreme_of_a_form_is_lost() {
        let mut values = vec![0.1; 3600];
        (values[1234], values[3599]) = (-7.0, 5.0);
        let kept = largest_of(&values, 720);
        assert_eq!((kept.len(), kept[1234 / 5], kept[719]), (720, -7.0, 5.0));
        assert_eq!(largest_of(&values[..16], 720), values[..16]);
    }
}
