// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Inspection of the ground lobes, as a cam measuring machine reports it.

use super::findings::Findings;
use super::job_timeline::JobTimeline;
use super::table::table as html_table;
use super::text::{fixed, signed};
use camwright::cam::form_tolerance::LobeZone;
use camwright::cam::lobe_inspection::LobeInspection;
use camwright::cam::wave_cause::WaveCause;
use camwright::math::units::{deg_from_rad, um_from_mm, wrap_turn};
use camwright::planner::PlannedLobe;
use camwright_files::convert::mm_from_m;
use camwright_planning::markup::escape;
use camwright_planning::{AnyPrepared, PreparedJob, wave_causes};

/// Heads of the table.
const HEADS: [(&str, bool); 10] = [
    ("lobe", true),
    ("size µm", false),
    ("timing °", false),
    ("timing to first °", false),
    ("base runout µm", false),
    ("lift opening µm", false),
    ("lift nose µm", false),
    ("lift closing µm", false),
    ("velocity µm/° (at °)", false),
    ("waves per turn (µm, Hz)", true),
];

/// A lobe whose finished outline and design are recorded.
struct InspectedLobe<'a> {
    planned: &'a PlannedLobe,
    inspection: LobeInspection,
}

impl InspectedLobe<'_> {
    fn name(&self) -> &str {
        &self.planned.design.name
    }

    /// The strongest waves with their amplitude, their frequency in the last pass, and their cause.
    fn waves(&self, prepared: &PreparedJob) -> String {
        let Some(pass) = self.planned.passes.last() else { return String::new() };
        let numbers: Vec<usize> = self.inspection.waves.iter().map(|wave| wave.per_turn).collect();
        let causes = wave_causes(prepared, self.planned, &numbers);
        let texts = self.inspection.waves.iter().zip(causes).map(|(wave, cause)| {
            let cause = match cause {
                Some(WaveCause::Wheel { multiple: 1 }) => ", rotation of the wheel".to_owned(),
                Some(WaveCause::Wheel { multiple }) => format!(", {multiple} × rotation of the wheel"),
                Some(WaveCause::Structure { axis }) => format!(", structure of {}", axis.joint()),
                Some(WaveCause::ContactMode { index }) => format!(", contact.modes.{index}"),
                Some(WaveCause::Drive { axis }) => format!(", drive of {}", axis.joint()),
                Some(WaveCause::Chatter) => ", chatter".to_owned(),
                None => String::new(),
            };
            let amplitude_um = fixed(um_from_mm(wave.amplitude_mm), 3);
            let frequency_hz = fixed(wave.per_turn as f64 / pass.turn_s(), 1);
            format!("{} ({amplitude_um}, {frequency_hz} Hz{cause})", wave.per_turn)
        });
        texts.collect::<Vec<_>>().join("; ")
    }
}

fn inspected_lobes<'a>(prepared: &'a PreparedJob, story: &JobTimeline<'_>) -> Vec<InspectedLobe<'a>> {
    (prepared.planned.lobes.iter())
        // A crank pin has no follower; its values are in a table of their own.
        .filter(|planned| !planned.design.contour.is_pin())
        .filter_map(|planned| {
            let design = &planned.design;
            let outlines = story.outlines.iter();
            let part = outlines.rev().find(|part| part.name == design.name && part.finished)?;
            let radii_mm: Vec<f64> = part.radius.iter().map(|radius| mm_from_m(*radius)).collect();
            let phase_rad = design.phase_on_rad(part.key_way);
            let inspection = LobeInspection::new(&radii_mm, &design.contour, phase_rad).ok()?;
            Some(InspectedLobe { planned, inspection })
        })
        .collect()
}

pub(super) fn table(out: &mut String, findings: &Findings<'_>) {
    let Ok(AnyPrepared::Ground(prepared)) = findings.again else { return };
    let lobes = inspected_lobes(prepared, findings.story);
    let Some(first) = lobes.first() else { return };
    let unknown = || "–".to_owned();
    let zone = |inspection: &LobeInspection, zone: LobeZone| {
        let found = inspection.zones.iter().find(|error| error.zone == zone);
        found.map_or_else(unknown, |error| {
            let (low, high) = error.lift_error;
            format!("{} to {}", signed(um_from_mm(low), 2), signed(um_from_mm(high), 2))
        })
    };
    let row = |lobe: &InspectedLobe<'_>| {
        let inspection = &lobe.inspection;
        let timing = inspection.mounting.phase_rad;
        let to_first = timing.zip(first.inspection.mounting.phase_rad).filter(|_| lobe.name() != first.name());
        let (velocity, at) = inspection.velocity_error;
        vec![
            escape(lobe.name()),
            signed(um_from_mm(inspection.size_mm), 2),
            timing.map_or_else(unknown, |rad| signed(deg_from_rad(rad), 4)),
            to_first.map_or_else(unknown, |(own, other)| signed(deg_from_rad(own - other), 4)),
            inspection.base_runout_mm.map_or_else(unknown, |mm| fixed(um_from_mm(mm), 2)),
            zone(inspection, LobeZone::Opening),
            zone(inspection, LobeZone::Nose),
            zone(inspection, LobeZone::Closing),
            format!("{} ({})", signed(um_from_mm(velocity), 2), fixed(deg_from_rad(wrap_turn(at)), 1)),
            escape(&lobe.waves(prepared)),
        ]
    };
    out.push_str("<section id=\"inspection\"><h2>Inspection</h2>");
    html_table(out, &HEADS, &lobes.iter().map(row).collect::<Vec<_>>());
    out.push_str(
        "<p class=\"faint\">Lift error of the follower of the design with the base circle at 0 and the lobe aligned in phase, \
         smallest to largest of each zone: opening and closing to the largest velocity, the nose between them. Velocity error: \
         change of the lift error over 1° of the cam. Timing: rotation of the lobe on the part, positive with the cam angle; – where a \
         rotation cannot be separated from an eccentricity. Waves: the three strongest with 15 or more per turn, their frequency at the \
         planned speed of the last pass, and the only vibration of the machine that has it (none is named where the speed varies by more \
         than 2 %): rotation of the wheel, structure or loops of a drive, a mode of the contact, or chatter where its forecast grows. Errors of lifts \
         given as angles of an arm are in thousandths of a degree.</p></section>\n",
    );
}
