// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;

fn with(overrides: &[&str]) -> Result<TurnedJob, Vec<String>> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let located = locate("jobs", "turned_cam", "yaml", None).expect("it is shipped");
    read(&located, &overrides).map_err(|errors| errors.iter().map(ToString::to_string).collect())
}

fn refusal(overrides: &[&str]) -> String {
    with(overrides).expect_err("it is no job").join("\n")
}

/// A job with this surface, from a bar that holds it.
fn with_surface(surface: &str) -> Result<TurnedJob, Vec<String>> {
    with(&[&format!("surface={surface}"), "turned={from_mm: 20.0, to_mm: 0.0}"])
}

#[test]
fn what_is_left_out_has_its_default() {
    let located = locate("jobs", "turned_cam", "yaml", None).expect("it is shipped");
    let text = located
        .text
        .lines()
        .filter(|line| !line.starts_with("tolerance_um"))
        .fold(String::new(), |all, line| all + line + "\n");
    let job = parse(&Located { text, ..located }, &[]).unwrap();
    assert_eq!((job.spec.angles, job.spec.speed), (360, TurningSpeed::Fastest));
    assert!((job.tolerance_mm - 0.002).abs() < 1e-15 && (job.spec.clearance_mm - 1.0).abs() < 1e-15);
    assert_eq!((job.grid.azimuths, job.grid.columns), (720, 1201), "ten columns in a feed of 0.2 mm, over 24 mm");
    assert!(job.grid.from_mm.abs() < 1e-15 && (job.grid.to_mm - 24.0).abs() < 1e-15);
    assert_eq!(job.hash.len(), 64);
}

#[test]
fn every_law_of_the_spindle_means_its_speed() {
    for (law, speed) in [
        ("{law: fastest}", TurningSpeed::Fastest),
        ("{law: varied}", TurningSpeed::Varied),
        ("{law: constant, rpm: 60.0}", TurningSpeed::Constant(2.0 * std::f64::consts::PI)),
    ] {
        assert_eq!(with(&[&format!("spindle={law}")]).unwrap().spec.speed, speed);
    }
}

/// The bar has a circle in the rake plane too: √(B² − H²), and the part its least radius there.
#[test]
fn default_stock_is_the_bar_over_the_part_in_the_rake_plane() {
    let job = with(&[]).unwrap();
    let stock_mm = (24.6_f64 * 24.6 - 196.0).sqrt() - (400.0_f64 - 196.0).sqrt();
    assert!((job.spec.passes.stock_mm - stock_mm).abs() < 1e-2, "{} {stock_mm}", job.spec.passes.stock_mm);
    assert!(job.spec.passes.stock_mm >= stock_mm, "no less");
    let result = with(&["roughing.stock_mm=7.0"]).unwrap();
    assert!((result.spec.passes.stock_mm - 7.0).abs() < 1e-15);
    // Without roughing, finishing takes it all.
    let at_once = with(&["roughing=null"]).unwrap().spec;
    assert_eq!(at_once.passes.stocks_mm().unwrap(), [0.0]);
    assert_eq!(at_once.passes.rough_feed, at_once.feed);
}

#[test]
fn solids_by_formula_have_the_radius_of_the_drawing() {
    let radius = |surface: &str, azimuth_deg: f64, z_mm: f64| {
        let job = with_surface(surface).unwrap_or_else(|errors| panic!("{errors:?}"));
        job.spec.surface.radius(azimuth_deg.to_radians(), z_mm)
    };
    let cylinder = "{kind: cylinder, from_mm: 0.0, to_mm: 20.0, radius_mm: 21.5}";
    assert!((radius(cylinder, 77.0, 3.0) - 21.5).abs() < 1e-12);
    let eccentric =
        "{kind: eccentric, from_mm: 0.0, to_mm: 20.0, radius_mm: 21.0, eccentricity_mm: 2.5, azimuth_deg: 40.0}";
    assert!(
        (radius(eccentric, 40.0, 3.0) - 23.5).abs() < 1e-12 && (radius(eccentric, 220.0, 3.0) - 18.5).abs() < 1e-12
    );
    let cone = "{kind: elliptic_cone, from_mm: 0.0, to_mm: 20.0, first_mm: {from: 24.0, to: 22.0}, second_mm: 21, azimuth_deg: 30.0}";
    assert!((radius(cone, 30.0, 0.0) - 24.0).abs() < 1e-12 && (radius(cone, 30.0, 20.0) - 22.0).abs() < 1e-12);
    assert!((radius(cone, 120.0, 20.0) - 21.0).abs() < 1e-12);
    let lobed = "{kind: lobed, from_mm: 0.0, to_mm: 20.0, mean_mm: 22.0, waves: [{per_turn: 3, amplitude_mm: 0.4, phase_deg: {from: 0.0, to: 90.0}}]}";
    assert!((radius(lobed, 0.0, 0.0) - 22.4).abs() < 1e-12 && (radius(lobed, 0.0, 20.0) - 22.0).abs() < 1e-12);
    assert!((radius(lobed, 30.0, 20.0) - 22.4).abs() < 1e-12, "cos(3 · 30° − 90°)");
}

#[test]
fn all_errors_are_reported_at_once_with_the_file_keys() {
    let errors = refusal(&["bar_radius_mm=-1.0", "form_grid.azimuths=8", "tolerance_um=0.0", "titel=x"]);
    for words in [
        "bar_radius_mm is -1; it must be 0.000001 to 10000 (set by bar_radius_mm=-1.0)",
        "form_grid.azimuths is 8; it must be 16 to 7200 (set by form_grid.azimuths=8)",
        "tolerance_um is 0; it must be 0.000001 to 1000000",
        "titel is an unknown key; did you mean title?",
    ] {
        assert!(errors.contains(words), "{words}: {errors}");
    }
    let errors = refusal(&[
        "spindle={law: constant}",
        "finishing={along_z_mm: 0.1, along_curve_mm: 0.1}",
        "machine=no_such_machine",
    ]);
    for words in [
        "spindle.law constant needs it",
        "finishing needs one of along_z_mm and along_curve_mm, it has both",
        "known machines:",
    ] {
        assert!(errors.contains(words), "{words}: {errors}");
    }
}

#[test]
fn values_out_of_their_range_are_refused() {
    for (overrides, words) in [
        (&["finishing={}"][..], "finishing needs one of along_z_mm and along_curve_mm, the feed per turn"),
        (&["roughing.along_z_mm=null"], "roughing needs one of"),
        (&["roughing.leaves_mm=-0.1"], "roughing.leaves_mm is -0.1; it must be 0 to 1000"),
        (&["spindle.rpm=100.0"], "spindle.rpm is only for spindle.law constant"),
        (&["spindle={law: varied, rpm: 100.0}"], "spindle.rpm is only for spindle.law constant"),
        (&["spindle={law: constant, rpm: -100.0}"], "spindle.rpm is -100; it must be 0.001 to 100000"),
        (&["turned.from_mm=0.0"], "turned from 0 to 0 mm; the two must differ"),
        (&["form_grid.column_mm=0.00001"], "at most 2097152 are allowed"),
        (&["faults=[{kind: no_such_fault, at_s: 1.0}]"], "no_such_fault"),
        (&["wheel_radius_mm=60.0"], "wheel_radius_mm"),
        (
            &["surface.profiles.low.gauge={kind: flat}"],
            "profile low: gauge is for ground lobes; remove it from a turned part",
        ),
        (
            &["surface.profiles.low.base_radius_mm=0.0"],
            "surface.profiles.low.base_radius_mm is 0; it must be 0.000001 to 10000",
        ),
        (&["surface.cams.1.profile=none"], "there is no profile none; the surface has high, low"),
        (&["surface.cams.1.from_mm=1.0"], "does not increase"),
        (&["surface.cams.0.to_mm=-1.0"], "the part ends at z = -1 mm"),
        (&["surface.cams.0.phase_deg=1e9"], "the phase of a cam is 17453"),
        (&["surface.cams.1.to_mm=1e9"], "the z at which a cam ends is 1000000000"),
        (&["surface.cams=[]"], "surface.cams has 0 entries; it must have 1 to 100"),
    ] {
        let errors = refusal(overrides);
        assert!(
            errors.contains(words) && errors.starts_with("params/jobs/turned_cam.yaml") || errors.contains("built-in"),
            "{overrides:?}: {errors}"
        );
        assert!(errors.contains(words), "{overrides:?}: {errors}");
    }
}

#[test]
fn a_solid_that_is_none_is_refused_at_its_key() {
    for (surface, words) in [
        ("{kind: cylinder, from_mm: 0.0, to_mm: 20.0, radius_mm: -2.0}", "the radius of the cylinder is -2"),
        ("{kind: cylinder, from_mm: 20.0, to_mm: 20.0, radius_mm: 2.0}", "it must end above z = 20 mm"),
        ("{kind: cylinder, from_mm: 0.0, to_mm: 1e9, radius_mm: 2.0}", "the z at which the part ends is 1000000000"),
        ("{kind: eccentric, from_mm: 0.0, to_mm: 20.0, radius_mm: 2.0, eccentricity_mm: 3.0}", "the eccentricity is 3"),
        (
            "{kind: elliptic_cone, from_mm: 0.0, to_mm: 20.0, first_mm: 9.0, second_mm: {from: 9.0, to: -9.0}}",
            "it must stay above 0 mm",
        ),
        (
            "{kind: lobed, from_mm: 0.0, to_mm: 20.0, mean_mm: 9.0, waves: [{per_turn: 0, amplitude_mm: 1.0}]}",
            "surface.waves.0.per_turn is 0; it must be 1 to 720",
        ),
        ("{kind: pyramid, from_mm: 0.0, to_mm: 20.0}", "pyramid"),
        ("{kind: cylinder, from_mm: 0.0, to_mm: 20.0, radius_mm: 2.0, colour: red}", "colour"),
        ("{kind: cylinder, from_mm: 0.0, to_mm: 20.0}", "radius_mm"),
        (
            "{kind: elliptic_cone, from_mm: 0.0, to_mm: 20.0, first_mm: wide, second_mm: 9.0}",
            "surface.first_mm is the text \"wide\"; it must be a number or keys with values",
        ),
    ] {
        let errors = with_surface(surface).expect_err("no surface").join("\n");
        assert!(errors.contains(words), "{surface}: {errors}");
    }
}

/// Lines of what is wrong inside the surface.
#[test]
fn an_unknown_surface_key_is_reported_with_its_line() {
    let located = locate("jobs", "turned_cam", "yaml", None).unwrap();
    for (from, to) in [
        ("phase_deg: 20.0", "phase_dge: 20.0"),
        ("base_radius_mm: 20.0", "base_radius: 20.0"),
        ("deepest_mm", "deepst_mm"),
    ] {
        let text = located.text.replacen(from, to, 1);
        let line = text.lines().position(|line| line.contains(to)).unwrap() + 1;
        let error = parse(&Located::new("job.yaml", text), &[]).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("job.yaml:{line}: ")) && error.contains(to.split(':').next().unwrap()),
            "{error}"
        );
    }
}

#[test]
fn every_file_that_is_named_is_in_the_hash() {
    let folder = tempfile::tempdir().unwrap();
    let located = locate("jobs", "turned_cam", "yaml", None).unwrap();
    let at = located.text.find("        segments:").unwrap();
    let end = located.text.find("    - name: low").unwrap();
    let text = format!("{}        table: own.csv\n{}", &located.text[..at], &located.text[end..]);
    let job = Located::new(folder.path().join("job.yaml"), text);
    let hash = |lift_mm: f64| {
        let row = |k: u32| format!("{k},{:.6}\n", 0.5 * lift_mm * (1.0 - f64::from(k).to_radians().cos()));
        let rows: String = (0..360).map(row).collect();
        std::fs::write(folder.path().join("own.csv"), format!("cam_angle_deg,lift_mm\n{rows}")).unwrap();
        parse(&job, &[]).unwrap_or_else(|error| panic!("{error}")).hash
    };
    let (first, other) = (hash(4.5), hash(4.4));
    assert_ne!(first, other);
    assert_eq!(first, hash(4.5));
}
