// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A turned part in messages: the bar that is clamped, how its surface came out, and where it is off.

use super::prepared::{PreparedTurning, highest_cusp};
use camwright::math::units::TURN_RAD;
use camwright::simulation::turned_part::FormMap;
use camwright_files::convert::m_from_mm;
use camwright_msgs::camwright_msgs::msg::{FormMap as FormMapMessage, TurnedResult};
use camwright_msgs::camwright_msgs::srv::LoadBarRequest;
use camwright_msgs::std_msgs::msg::Header;

/// Fields of a form map in a message: every 4°, and so many along the axis. Both lists of them are 29 kB.
const MAP_AZIMUTHS: usize = 90;
const MAP_COLUMNS: usize = 40;

/// The bar that a job begins with.
#[must_use]
pub fn bar(prepared: &PreparedTurning) -> LoadBarRequest {
    let (spec, grid) = (&prepared.job.spec, &prepared.job.grid);
    let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    LoadBarRequest {
        name: spec.name.clone(),
        radius: m_from_mm(spec.bar_radius_mm),
        part_zero: m_from_mm(spec.part_zero_mm),
        azimuths: count(grid.azimuths),
        columns: count(grid.columns),
        from_z: m_from_mm(grid.from_mm),
        to_z: m_from_mm(grid.to_mm),
    }
}

/// Feed of the finishing pass per turn (mm).
fn feed_mm(prepared: &PreparedTurning) -> f64 {
    prepared.planned.passes.last().map_or(0.0, |pass| {
        let (path, at) = (&pass.path, pass.path.x().start());
        (path.z_at(at + TURN_RAD).value - path.z_at(at).value).abs()
    })
}

/// Predicted time from the way to the first pass to the end of the last (s).
#[must_use]
pub fn turning_s(prepared: &PreparedTurning) -> f64 {
    let segments = prepared.planned.plan.segments.iter().filter(|segment| segment.lobe == Some(0));
    let ticks: u64 = segments.map(|segment| segment.ticks).sum();
    let ticks = ticks as f64;
    ticks * prepared.machine.cycle_time_s()
}

/// Result of a part, from the map of its form; its time equals the prediction.
#[must_use]
pub fn turned_result(prepared: &PreparedTurning, form: &FormMap) -> TurnedResult {
    let (highest, lowest) = (form.highest(), form.lowest());
    let cusp = prepared.planned.passes.last().and_then(|pass| highest_cusp(prepared, pass));
    // A surface that was planned has its sections.
    let cusp_mm = cusp.map_or(0.0, |cusp| cusp.height_mm);
    let worst = if highest.deviation_mm.abs() >= lowest.deviation_mm.abs() { highest } else { lowest };
    TurnedResult {
        name: prepared.job.spec.name.clone(),
        passes: u32::try_from(prepared.planned.passes.len()).unwrap_or(u32::MAX),
        turns: prepared.planned.passes.iter().map(|pass| pass.turns).sum(),
        duration: turning_s(prepared),
        form_error_max: m_from_mm(worst.deviation_mm),
        form_error_max_azimuth: worst.azimuth_rad,
        form_error_max_z: m_from_mm(worst.z_mm),
        form_error_highest: m_from_mm(highest.deviation_mm),
        form_error_lowest: m_from_mm(lowest.deviation_mm),
        form_error_rms: m_from_mm(form.rms_mm()),
        form_error_allowed: m_from_mm(prepared.job.tolerance_mm + cusp_mm),
        cusp_height: form.cusps(feed_mm(prepared)).map_or(f64::NAN, |cusps| m_from_mm(cusps.max_mm)),
        cusp_height_theory: m_from_mm(cusp_mm),
    }
}

/// The map of a form for others: no extreme of it is lost.
#[must_use]
pub fn form_map_message(prepared: &PreparedTurning, form: &FormMap, tick: u64, header: Header) -> FormMapMessage {
    let places = form.places_mm();
    let (azimuths, columns) = (MAP_AZIMUTHS.min(form.azimuths()), MAP_COLUMNS.min(places.len()));
    let bins = form.bins(azimuths, columns);
    let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    #[allow(clippy::cast_possible_truncation, reason = "seven digits of some micrometres")]
    let short = |mm: f64| m_from_mm(mm) as f32;
    FormMapMessage {
        header,
        tick,
        name: prepared.job.spec.name.clone(),
        azimuths: count(azimuths),
        columns: count(columns),
        from_z: places.first().map_or(0.0, |mm| m_from_mm(*mm)),
        to_z: places.last().map_or(0.0, |mm| m_from_mm(*mm)),
        lowest: bins.iter().map(|bin| short(bin.min_mm)).collect(),
        highest: bins.iter().map(|bin| short(bin.max_mm)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{plan_turned, simulate_turned, turned_form};
    use camwright::machine::description::Effect;
    use camwright::math::units::um_from_mm;
    use camwright_files::any_job::{self, AnyJob};
    use camwright_files::convert::mm_from_m;

    fn prepared(set: &[&str]) -> PreparedTurning {
        let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
        let Ok(AnyJob::Turned(job)) = any_job::load("turned_cam", &set) else { panic!("a turning job") };
        plan_turned(*job, None).unwrap_or_else(|error| panic!("{error}"))
    }

    /// A short piece of the default job: within 2 um and the cusps on an ideal lathe, and worse on its own; the report shows the actual
    /// error.
    #[test]
    fn a_turned_part_keeps_its_tolerance_on_an_ideal_lathe() {
        let prepared = prepared(&["turned.from_mm=24", "turned.to_mm=22", "form_grid.azimuths=180"]);
        let result = |without: &[Effect]| {
            let (_, part) = simulate_turned(&prepared, without).unwrap();
            turned_result(&prepared, &turned_form(&prepared, &part).unwrap())
        };
        let (ideal, own) = (result(&Effect::ALL), result(&[]));
        let um = |m: f64| um_from_mm(mm_from_m(m));
        eprintln!("ideal {:+.3} um, own drives {:+.3} um", um(ideal.form_error_max), um(own.form_error_max));
        assert!((ideal.form_error_highest - ideal.cusp_height_theory).abs() < 3e-8, "{ideal:?}");
        assert!(ideal.form_error_lowest > -3e-8, "{ideal:?}");
        assert!(own.form_error_max.abs() > ideal.form_error_max.abs());
        let allowed_mm = prepared.job.tolerance_mm + mm_from_m(own.cusp_height_theory);
        assert!((mm_from_m(own.form_error_allowed) - allowed_mm).abs() < 1e-12);
        assert!((ideal.cusp_height / ideal.cusp_height_theory - 1.0).abs() < 0.1, "{ideal:?}");
    }
}
