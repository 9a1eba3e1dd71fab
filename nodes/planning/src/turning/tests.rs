// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::{AnyPrepared, prepare_any};
use camwright::interpolator::MotionOutcome;
use camwright::machine::description::Effect;
use camwright::machine::description::MachineDescription;
use camwright::math::units::um_from_mm;
use camwright::planner::MAX_SURFACE_LOOKS;
use camwright::simulation::turned_part::{PartGrid, TurnedPart};
use camwright_files::ConfigError;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::locate::{Located, locate};
use camwright_files::turning_file::{self, TurnedJob};
use std::path::Path;

fn prepared(overrides: &[&str]) -> Result<PreparedTurning, ConfigError> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    plan_turned(turning_file::load("turned_cam", &overrides)?, None)
}

fn refusal(overrides: &[&str]) -> String {
    prepared(overrides).expect_err("it cannot be made").to_string()
}

#[test]
fn the_shipped_part_is_planned_with_one_hash_and_ordinary_drives() {
    let (first, again) = (prepared(&[]).unwrap(), prepared(&[]).unwrap());
    eprintln!("{}", first.summary());
    assert_eq!(first.plan_hash(), again.plan_hash());
    assert_eq!(first.plan_hash().len(), 64);
    assert!((20.0..60.0).contains(&first.duration_s()), "{}", first.duration_s());
    let looks = first.planned.surface_looks;
    eprintln!("{looks} looks at the surface");
    assert!(10 * looks < MAX_SURFACE_LOOKS, "{looks} looks at the surface");
}

#[test]
fn every_refusal_names_the_file_and_the_line_of_what_causes_it() {
    for (overrides, place, words) in [
        (&["machine=cam_grinder"][..], "turned_cam.yaml: ", "the machine grinds with a wheel"),
        (&["bar_radius_mm=24.0"], "turned_cam.yaml: ", "at least 24.5"),
        (&["turned.from_mm=25.0"], "turned_cam.yaml: ", "the z at which turning begins is 25"),
        (&["turned.to_mm=-1.0"], "turned_cam.yaml: ", "the z at which turning ends is -1"),
        (&["roughing.stock_mm=4.0"], "turned_cam.yaml: ", "the stock (mm) is 4"),
        (&["roughing.deepest_mm=0.001"], "turned_cam.yaml: ", "the number of roughing passes is"),
        (&["roughing.leaves_mm=9.0"], "turned_cam.yaml: ", "the stock for finishing is 9"),
        (&["finishing.along_z_mm=8.5"], "turned_cam.yaml: ", "the feed per turn is 8.5"),
        (&["angles_per_turn=100"], "turned_cam.yaml: ", "angles_per_turn is 100; it must be 180 to 3600"),
        (&["part_zero_mm=100.0"], "turned_cam.yaml: ", "z_axis goes to"),
        (&["clearance_mm=100.0"], "turned_cam.yaml: ", "x_axis goes to"),
        (&["spindle={law: constant, rpm: 590.0}"], "turned_cam.yaml: ", "the acceleration of x_axis"),
        (&["finishing.along_z_mm=0.002", "form_grid.column_mm=0.02"], "turned_cam.yaml:", "the 3 passes have 58"),
    ] {
        let error = refusal(overrides);
        assert!(error.contains(place) && error.contains(words), "{overrides:?}: {error}");
    }
}

/// Without overrides a refusal names the line of the file.
#[test]
fn a_refusal_points_to_the_line_of_the_file_that_was_read() {
    let located = locate("jobs", "turned_cam", "yaml", None).unwrap();
    let changed = |from: &str, to: &str| {
        let text = located.text.replacen(from, to, 1);
        assert_ne!(text, located.text, "{from}");
        let line = text.lines().position(|line| line.contains(to.trim_end())).expect("what was put in") + 1;
        let read = Located::new(located.path.clone(), text);
        let error = turning_file::parse(&read, &[]).and_then(|job| plan_turned(job, None)).expect_err("refused");
        (error, u64::try_from(line).expect("a line"))
    };
    for (from, to) in [
        ("bar_radius_mm: 24.6", "bar_radius_mm: 24.1"),
        ("deepest_mm: 3.0", "deepest_mm: 0.0005"),
        ("turned: {from_mm: 24.0", "turned: {from_mm: 26.0"),
        ("part_zero_mm: 2.0 ", "part_zero_mm: 90.0 "),
        ("from_mm: 20.0", "from_mm: 3.0"),
        ("rise_mm: 4.5}", "rise_mm: 4.6}"),
        ("profile: low", "profile: lower"),
    ] {
        let (error, line) = changed(from, to);
        assert_eq!(error.place.file, located.path, "{error}");
        let found = error.place.line.expect("a line");
        // An error of a lift is reported at the start of the lift.
        assert!(found == line || (found + 2 >= line && to.starts_with("rise")), "{to}: {error}");
    }
}

/// An insert at the height of the axis does not clear a cam like this; the sentence says where, and what height would do.
#[test]
fn an_insert_at_a_height_at_which_it_touches_is_blamed_on_its_machine() {
    let job = turning_file::load("turned_cam", &[]).unwrap();
    let at = |height_mm: f64| {
        let mut job = job.clone();
        job.machine = job.machine.with_overrides(&[format!("insert.height_mm={height_mm}")]).unwrap();
        plan_turned(job, None).expect_err("it touches, scrapes or misses").to_string()
    };
    for (height_mm, words) in [
        (0.0, "0.000 mm below centre the flank clears the surface by"),
        (14.0, "with the insert 14.000 mm above centre the flank clears the surface by"),
        (-19.9, "the surface lies at"),
        (-25.0, "the part has a radius of"),
    ] {
        let error = at(height_mm);
        assert!(error.contains(words) && error.contains("z = "), "{height_mm}: {error}");
        assert!(error.contains("below centre it clears this surface, best "), "{height_mm}: {error}");
        assert!(error.starts_with("lathe"), "{error}");
    }
}

/// The contact of the shipped cam lies beyond a short arc; the sentence says where, names the arc of the machine file, and what to do.
#[test]
fn an_edge_that_is_too_short_is_blamed_on_its_machine() {
    let job = turning_file::load("turned_cam", &[]).unwrap();
    let with_edge = |text: &str| {
        let located = locate("machines", "lathe", "yaml", None).unwrap();
        let text = located.text.replacen("  relief_deg:", &format!("{text}  relief_deg:"), 1);
        let line = text.lines().position(|line| line.starts_with("  edge:")).map(|line| line + 1);
        let machine = camwright_files::machine_file::parse(Path::new("own_lathe.yaml"), &text, &[]).unwrap();
        (plan_turned(TurnedJob { machine, ..job.clone() }, None), line)
    };
    let (whole, _) = with_edge("");
    let whole = whole.unwrap();
    let summary = turning_summary(&whole).unwrap();
    let edge = summary.edge.clone().expect("it cuts");
    assert!(edge.from.angle_deg < -30.0 && edge.to.angle_deg > 1.0 && edge.rotates && edge.arc_deg.is_none());
    let notes = turning_notes(&summary).join("\n");
    let words = format!("edge      cuts from {:.2} deg at C ", edge.from.angle_deg);
    assert!(notes.contains(&words) && notes.contains("rotating insert, the whole circle"), "{notes}");
    let arc = |from_deg: f64, to_deg: f64| with_edge(&format!("  edge: {{from_deg: {from_deg}, to_deg: {to_deg}}}\n"));
    // The printed angles are an arc that does.
    let (fits, _) = arc((100.0 * edge.from.angle_deg).round() / 100.0, (100.0 * edge.to.angle_deg).round() / 100.0);
    let fits = fits.unwrap();
    assert_eq!(fits.planned.plan, whole.planned.plan);
    assert!(turning_notes(&turning_summary(&fits).unwrap()).join("\n").contains("rotating insert, -"));
    for (from_deg, to_deg, angle_deg) in [(-20.0, 90.0, edge.from.angle_deg), (-90.0, 0.5, edge.to.angle_deg)] {
        let (refused, line) = arc(from_deg, to_deg);
        let error = refused.expect_err("a part of the edge that is not there").to_string();
        let place = format!("own_lathe.yaml:{}: ", line.expect("a line"));
        let wanted = [
            format!("cuts with the insert's edge at {angle_deg:.2} deg, turned to "),
            format!("the edge goes from {from_deg:.2} to {to_deg:.2} deg"),
            "turn the insert in its holder".to_owned(),
        ];
        assert!(error.starts_with(&place), "{place}: {error}");
        assert!(wanted.iter().all(|words| error.contains(words)), "{wanted:?}: {error}");
    }
}

#[test]
fn a_cell_with_another_machine_is_refused_and_the_same_machine_is_taken() {
    let job = || turning_file::load("turned_cam", &[]).unwrap();
    let now = |name: &str| {
        let machine = camwright_files::machine_file::parse(
            Path::new(name),
            &locate("machines", name, "yaml", None).unwrap().text,
            &[],
        );
        let description = machine.unwrap().description;
        MachineNow { wheels: description.wheel.new_radius_mm.into(), description }
    };
    let error = plan_turned(job(), Some(&now("cam_grinder"))).expect_err("another machine").to_string();
    assert!(error.contains("turned_cam.yaml:6: the job is for machine lathe, the cell has cam_grinder"), "{error}");
    let prepared = plan_turned(job(), Some(&now("lathe"))).unwrap();
    assert_eq!(prepared.plan_hash(), plan_turned(job(), None).unwrap().plan_hash());
}

#[test]
fn any_job_is_planned_by_its_schema() {
    let turned = prepare_any("turned_cam", &[], None).unwrap();
    assert!(matches!(turned, AnyPrepared::Turned(_)));
    assert!(turned.summary().starts_with("turned_cam: 3 passes, "), "{}", turned.summary());
    let ground = prepare_any("eccentric", &[], None).unwrap();
    assert!(matches!(ground, AnyPrepared::Ground(_)));
    assert_eq!((turned.plan_hash().len(), ground.plan_hash().len()), (64, 64));
    assert!(ground.duration_s() > 1.0 && ground.summary().starts_with("eccentric: 1 lobe,"), "{}", ground.summary());
}

/// The whole job, from the pages that would be sent: what ideal drives leave is the cusps of the feed, f²/8 · (1/R + κ) where the section
/// curves by κ; ordinary drives lag, and good ones less.
#[test]
fn ideal_drives_leave_the_cusps_of_the_feed_and_ordinary_ones_some_micrometres() {
    let prepared = prepared(&[]).unwrap();
    let um = |machine: &MachineDescription| {
        let (simulated, part) = simulate_turned_on(&prepared, machine).unwrap();
        assert_eq!(simulated.outcome, MotionOutcome::Completed);
        let map = turned_form(&prepared, &part).unwrap();
        (um_from_mm(map.lowest().deviation_mm), um_from_mm(map.highest().deviation_mm))
    };
    let ideal = Effect::ALL.iter().fold(prepared.machine.clone(), |machine, effect| machine.without(*effect));
    let good = prepared.machine.clone().with_good_drives().expect("the lathe has them");
    let (ideal, own, good) = (um(&ideal), um(&prepared.machine), um(&good));
    eprintln!("ideal drives {ideal:.3?} um, ordinary {own:.3?} um, good {good:.3?} um");
    let cusp_um = um_from_mm(0.2 * 0.2 / 8.0 / 8.0);
    assert!(ideal.0 > -0.05 && ideal.1 > cusp_um && ideal.1 < 2.0 * cusp_um, "{ideal:?}, cusps {cusp_um}");
    let off = |(low, high): (f64, f64)| f64::max(-low, high - cusp_um);
    let allowed_um = um_from_mm(prepared.job.tolerance_mm);
    assert!(off(good) < off(own) && off(own) < allowed_um, "{own:?} {good:?}, allowed {allowed_um}");
    assert!(off(own) > 1.0, "{own:?}");
}

#[test]
fn a_part_on_another_grid_has_no_form() {
    let prepared = prepared(&[]).unwrap();
    let grid = PartGrid { from_mm: 100.0, to_mm: 110.0, columns: 10, ..prepared.job.grid };
    let part = TurnedPart::round("other".into(), grid, 20.0).unwrap();
    let error = turned_form(&prepared, &part).expect_err("elsewhere").to_string();
    assert_eq!(error, "the part has no column from 0 to 24 mm");
}

/// Every key with implausible values: planned or refused in a sentence with its file, never a panic, never for long.
#[test]
fn hostile_values_are_refused_or_planned() {
    let keys = [
        "name",
        "machine",
        "surface",
        "surface.kind",
        "surface.profiles",
        "surface.profiles.0.lift",
        "surface.profiles.0.base_radius_mm",
        "surface.cams",
        "surface.cams.0.from_mm",
        "surface.cams.1.to_mm",
        "surface.cams.1.phase_deg",
        "turned",
        "turned.from_mm",
        "turned.to_mm",
        "bar_radius_mm",
        "part_zero_mm",
        "roughing",
        "roughing.stock_mm",
        "roughing.leaves_mm",
        "roughing.deepest_mm",
        "roughing.along_z_mm",
        "roughing.along_curve_mm",
        "finishing",
        "finishing.along_z_mm",
        "finishing.along_curve_mm",
        "angles_per_turn",
        "spindle",
        "spindle.law",
        "spindle.rpm",
        "clearance_mm",
        "rapid_speed_mm_s",
        "form_grid.azimuths",
        "form_grid.column_mm",
        "tolerance_um",
        "faults",
    ];
    let values = ["0", "-1", "1e-9", "0.1", "1e300", "varied", "{}"];
    let short = ["turned={from_mm: 24.0, to_mm: 23.0}", "form_grid={column_mm: 0.1}"];
    let (mut made, mut refused) = (0, 0);
    for key in keys {
        for value in values {
            let set = format!("{key}={value}");
            let overrides: Vec<&str> = short.into_iter().chain([set.as_str()]).collect();
            match prepared(&overrides) {
                Ok(prepared) => {
                    made += 1;
                    assert!(prepared.duration_s().is_finite() && turning_summary(&prepared).is_some(), "{set}");
                }
                Err(error) => {
                    refused += 1;
                    let text = error.to_string();
                    assert!(error.message.len() > 15 && text.contains(".yaml"), "{set}: {text}");
                }
            }
        }
    }
    assert!(made > 20 && refused > 100, "made {made}, refused {refused}");
}
