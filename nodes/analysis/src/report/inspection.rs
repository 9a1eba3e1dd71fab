//! Inspection of the ground lobes, as a cam measuring machine reports it.

use super::findings::Findings;
use super::table::table as html_table;
use super::text::{fixed, signed};
use camwright::cam::lobe_inspection::{LobeInspection, LobeZone};
use camwright::math::units::{deg_from_rad, um_from_mm, wrap_turn};
use camwright_files::convert::mm_from_m;
use camwright_planning::AnyPrepared;
use camwright_planning::markup::escape;

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
    ("waves per turn (µm)", true),
];

/// Lobes whose finished outline and design are recorded.
pub(super) fn inspections(findings: &Findings<'_>) -> Vec<(String, LobeInspection)> {
    let Ok(AnyPrepared::Ground(prepared)) = findings.again else { return Vec::new() };
    let designs = prepared.planned.lobes.iter().map(|lobe| &lobe.design);
    designs
        .filter_map(|design| {
            let outlines = findings.story.outlines.iter();
            let part = outlines.rev().find(|part| part.name == design.name && part.finished)?;
            let radii_mm: Vec<f64> = part.radius.iter().map(|radius| mm_from_m(*radius)).collect();
            let phase_rad = design.phase_on_rad(part.key_way);
            let inspection = LobeInspection::new(&radii_mm, &design.contour, phase_rad).ok()?;
            Some((design.name.clone(), inspection))
        })
        .collect()
}

pub(super) fn table(out: &mut String, findings: &Findings<'_>) {
    let inspections = inspections(findings);
    let Some((first, reference)) = inspections.first() else { return };
    let unknown = || "–".to_owned();
    let zone = |inspection: &LobeInspection, zone: LobeZone| {
        let found = inspection.zones.iter().find(|error| error.zone == zone);
        found.map_or_else(unknown, |error| {
            let (low, high) = error.lift_error;
            format!("{} to {}", signed(um_from_mm(low), 2), signed(um_from_mm(high), 2))
        })
    };
    let row = |(name, inspection): &(String, LobeInspection)| {
        let timing = inspection.mounting.phase_rad;
        let to_first = timing.zip(reference.mounting.phase_rad).filter(|_| name != first);
        let waves: Vec<String> = (inspection.waves.iter())
            .map(|wave| format!("{} ({})", wave.per_turn, fixed(um_from_mm(wave.amplitude_mm), 3)))
            .collect();
        let (velocity, at) = inspection.velocity_error;
        vec![
            escape(name),
            signed(um_from_mm(inspection.size_mm), 2),
            timing.map_or_else(unknown, |rad| signed(deg_from_rad(rad), 4)),
            to_first.map_or_else(unknown, |(own, other)| signed(deg_from_rad(own - other), 4)),
            inspection.base_runout_mm.map_or_else(unknown, |mm| fixed(um_from_mm(mm), 2)),
            zone(inspection, LobeZone::Opening),
            zone(inspection, LobeZone::Nose),
            zone(inspection, LobeZone::Closing),
            format!("{} ({})", signed(um_from_mm(velocity), 2), fixed(deg_from_rad(wrap_turn(at)), 1)),
            escape(&waves.join(", ")),
        ]
    };
    out.push_str("<section id=\"inspection\"><h2>Inspection</h2>");
    html_table(out, &HEADS, &inspections.iter().map(row).collect::<Vec<_>>());
    out.push_str(
        "<p class=\"faint\">Lift error of the follower of the design with the base circle at 0 and the lobe aligned in phase, \
         smallest to largest of each zone: opening and closing to the largest velocity, the nose between them. Velocity error: \
         change of the lift error over 1° of the cam. Timing: rotation of the lobe on the part, positive with the cam angle; – where a \
         rotation cannot be separated from an eccentricity. Waves: the three strongest with 15 or more per turn. Errors of lifts \
         given as angles of an arm are in thousandths of a degree.</p></section>\n",
    );
}
