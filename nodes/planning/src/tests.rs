// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::inspect::inspection_table;
use super::*;
use camwright::math::units::rad_from_deg;
use camwright_files::locate::locate;

fn machine_now() -> MachineNow {
    let job = job_file::load("four_lobe_camshaft", &[]).unwrap();
    let wheels = job.machine.description.wheel.new_radius_mm.into();
    MachineNow { description: job.machine.description, wheels }
}

/// The four-lobe camshaft as if its intake table were for another follower.
fn with_follower(follower: &str) -> Result<PreparedJob, String> {
    let mut located = locate("jobs", "four_lobe_camshaft", "yaml", None).unwrap();
    located.text = located.text.replacen("{kind: roller, radius_mm: 8.5}", follower, 1);
    let job = job_file::parse(&located, &[]).map_err(|error| error.to_string())?;
    plan(job, None).map_err(|error| error.to_string())
}

fn refusal(overrides: &[&str]) -> String {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    prepare("eccentric", &overrides, None).unwrap_err().to_string()
}

#[test]
fn the_default_job_is_planned_with_one_hash_and_short_pages() {
    let prepared = prepare("four_lobe_camshaft", &[], Some(&machine_now())).unwrap();
    let again = prepare("four_lobe_camshaft", &[], Some(&machine_now())).unwrap();
    assert_eq!(prepared.plan_hash(), again.plan_hash());
    assert_eq!(prepared.plan_hash().len(), 64);
    assert!(prepared.planned.saved_by_not_indexing_s() > 0.0);
    assert_eq!(lobe_times_s(&prepared).len(), 4);
    assert!(lobe_times_s(&prepared).iter().sum::<f64>() < prepared.planned.plan.duration_s);
}

/// Three equal lobes are as high a third of a turn further, the arms of a brake half a turn.
#[test]
fn jobs_of_repeated_shapes_are_planned_and_repeat() {
    for (job, times, reach_mm) in [("plate_cam", 3.0, 50.0), ("brake_cam", 2.0, 31.5)] {
        let prepared = prepare(job, &[], None).unwrap();
        let contour = &prepared.planned.lobes[0].design.contour;
        let turn = 2.0 * std::f64::consts::PI;
        let radii = (0..720).map(|i| turn * f64::from(i) / 720.0).map(|azimuth| {
            let (here, there) = (contour.radius_at(azimuth), contour.radius_at(azimuth + turn / times));
            assert!((here - there).abs() < 1e-9, "{job}, {azimuth}: {here} {there}");
            here
        });
        let farthest = radii.fold(0.0, f64::max);
        assert!((farthest - reach_mm).abs() < 0.5, "{job}: {farthest}");
    }
}

/// The default job has a lobe that starts on its flank, as in JPS6156064B2.
#[test]
fn one_lobe_starts_on_its_flank() {
    let prepared = prepare("four_lobe_camshaft", &[], None).unwrap();
    let lift = |lobe: &PlannedLobe| lobe.design.contour.lift().sample(lobe.start_rad).value;
    assert!(prepared.planned.lobes.iter().any(|lobe| lift(lobe) > 0.5), "a flank");
    assert!((prepared.planned.lobes[0].design.phase_rad - rad_from_deg(210.0)).abs() < 1e-12);
}

#[test]
fn a_wheel_the_job_was_not_written_for_is_refused() {
    let error = prepare("eccentric", &[], Some(&machine_now())).unwrap_err().to_string();
    assert!(
        error.contains("eccentric.yaml:6: wheel_radius_mm is 15, the wheel mounted on cam_grinder has 60"),
        "{error}"
    );
}

#[test]
fn refusals_point_to_the_key_that_causes_them() {
    for (overrides, place, words) in [
        (vec!["infeed.total_mm=0.35"], "eccentric.yaml", "whole turns are needed"),
        (vec!["lobes.A.station=LS9"], "eccentric.yaml", "LS1, LS2, LS3, LS4"),
        (vec!["work_speed_rpm=3000"], "eccentric.yaml", "the largest work speed that fits"),
        (vec!["home.x_mm=20"], "eccentric.yaml", "home.x_mm"),
        (vec!["stock_mm=0.9"], "eccentric.yaml", "inside the 0.9 mm of stock"),
    ] {
        let error = refusal(&overrides);
        assert!(error.contains(place) && error.contains(words), "{overrides:?}: {error}");
    }
}

/// A table can be that of an arm: the lift of the intake lobe as the way of its roller.
#[test]
fn a_job_takes_an_oscillating_follower() {
    let on_arm = "{kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42, pivot_mm: 48, side: ahead}";
    let prepared = with_follower(on_arm).unwrap();
    let contour = &prepared.planned.lobes[0].design.contour;
    assert!(matches!(contour.follower(), camwright::cam::follower::Follower::OscillatingRoller { .. }));
    // The contact leads the pivot by most of a quarter turn.
    assert!(contour.azimuth(0.0) > 1.0, "{}", contour.azimuth(0.0));
    with_follower("{kind: mushroom, radius_mm: 8.5}").unwrap();
}

#[test]
fn a_follower_that_cannot_ride_is_refused_where_it_stands() {
    for (follower, words) in [
        (
            "{kind: oscillating_roller, radius_mm: 8.5, arm_mm: 20, pivot_mm: 48, side: ahead}",
            "an arm of 20 mm about a pivot 48 mm from the cam's axis cannot hold the roller at the prime radius of 24.5 mm, \
             which must be above 28 mm and below 68 mm",
        ),
        (
            "{kind: oscillating_flat, pivot_mm: 50, side: behind}",
            "profiles.intake.follower.arc_radius_mm is missing: Distance from the pivot",
        ),
        ("{kind: mushroom, radius_mm: -3}", "radius of the face -3 mm is not a positive number"),
        ("{kind: oscillating_flat, pivot_mm: 50, side: behind, arc_radius_mm: 50, offset_mm: 3}", "offset_mm"),
        // A roller on an arm gives the intake lobe hollow flanks; a flat face would need it round.
        ("{kind: flat}", "undercut"),
    ] {
        let error = with_follower(follower).err().unwrap();
        assert!(error.contains("four_lobe_camshaft.yaml:1") && error.contains(words), "{follower}: {error}");
    }
}

/// The jerk that each way to read a table costs stands beside the one that is used, and what smoothing did to the lift.
#[test]
fn the_summary_states_how_each_table_was_read() {
    let set = ["profiles.intake.lift.smooth_within_um=2".to_owned()];
    let lifts = summary(&prepare("four_lobe_camshaft", &set, None).unwrap()).lifts;
    let names = |index: usize| lifts[index].readings.iter().map(|reading| reading.reading).collect::<Vec<_>>();
    assert_eq!((lifts[0].profile.as_str(), lifts[0].blocks), ("intake", 3600));
    assert_eq!(names(0), ["smooth_within", "smoothest", "cubic_spline"]);
    assert_eq!(names(1), ["smoothest", "cubic_spline"]);
    let (smooth, half_digit, cubic) = (&lifts[0].readings[0], &lifts[0].readings[1], &lifts[0].readings[2]);
    assert!(smooth.is_used && !half_digit.is_used && !cubic.is_used);
    assert!(smooth.peak_jerk_mm_rad3 < half_digit.peak_jerk_mm_rad3);
    assert!(cubic.peak_jerk_mm_rad3 > 1000.0 * half_digit.peak_jerk_mm_rad3);
    assert!((1e-3..=2.000_001e-3).contains(&smooth.max_deviation_mm), "{smooth:?}");
    // The wheel's path exists for the smooth readings only: rounded figures make a spline that is undercut everywhere.
    let x_axis = |index: usize| lifts[0].readings[index].x_axis.as_ref().unwrap();
    assert!(x_axis(0).no_path.is_none() && x_axis(1).no_path.is_none() && x_axis(2).no_path.is_some());
    assert!([x_axis(0), x_axis(1)].iter().all(|x| x.jerk_mm_s3 < 0.5 * x.limit_mm_s3), "{:?}", lifts[0].readings);
    assert!(x_axis(2).jerk_mm_s3 > 100.0 * x_axis(2).limit_mm_s3);
    assert!((x_axis(0).work_speed_rpm - 60.0).abs() < 1e-9);
    assert!(smooth.rms_deviation_mm < smooth.max_deviation_mm);
}

/// Motion laws written into the job are planned exactly; a job without a table has nothing to read.
#[test]
fn a_job_of_motion_laws_is_planned() {
    let law = |law: &str| {
        let segments = format!(
            "profiles.eccentric.lift={{segments: [{{law: dwell, angle_deg: 140}}, \
             {{law: {law}, angle_deg: 110, rise_mm: 3}}, {{law: {law}, angle_deg: 110, rise_mm: -3}}]}}"
        );
        prepare("eccentric", &[segments, "work_speed_rpm=20".to_owned()], None)
    };
    let prepared = law("4-5-6-7").unwrap();
    assert!(summary(&prepared).lifts.is_empty());
    assert!((prepared.job.spec.profiles[0].lift.max_lift_mm() - 3.0).abs() < 1e-9);
    let error = law("harmonic").unwrap_err().to_string();
    assert!(error.contains("eccentric.yaml: profile eccentric: segment 1 (dwell)"), "{error}");
    assert!(error.contains("the jerk of the X axis would be unbounded"), "{error}");
}

/// A gauge reads the lift of the follower itself; a gauge that does not fit the hollow flanks is reported, one that cannot lie on the base
/// circle is refused.
#[test]
fn gauge_commands_cover_the_gauged_turns() {
    let with_gauge = |gauge: &str| with_follower(&format!("{{kind: roller, radius_mm: 8.5}}\n    gauge: {gauge}"));
    let prepared = with_gauge("{kind: roller, radius_mm: 8.5}").unwrap();
    let inspection = prepared.inspections[0].as_ref().unwrap();
    assert!(prepared.inspections[1].is_none(), "the exhaust lobes have no gauge");
    let table = inspection_table(inspection, prepared.job.spec.blocks_per_turn);
    let [angles_deg, lifts_mm, _] = table.columns() else { panic!("three columns") };
    assert_eq!((angles_deg.name, lifts_mm.name), ("cam_angle_deg", "lift_mm"));
    assert_eq!(angles_deg.values.len(), 3600);
    for (angle_deg, lift_mm) in angles_deg.values.iter().zip(&lifts_mm.values) {
        let lift = inspection.contour().lift().sample(rad_from_deg(*angle_deg)).value;
        assert!((lift_mm - lift).abs() < 1e-9, "{angle_deg}: {lift_mm}, {lift}");
    }
    assert!(inspection.overlooked().is_none());
    // The same lift under a thinner roller needs hollow flanks, and a flat gauge lies across them.
    let flat = with_follower("{kind: roller, radius_mm: 6.0}\n    gauge: {kind: flat}").unwrap();
    assert!(flat.inspections[0].as_ref().unwrap().overlooked().is_some());
    let error = with_gauge("{kind: knife, offset_mm: 16}").err().unwrap();
    assert!(error.contains("four_lobe_camshaft.yaml:12: profile intake: gauge: follower offset 16 mm"), "{error}");
}

/// Made by `camwright post`, read from the disk and ground: what the blocks and the rounding of their corners leave, and the machine's drives.
#[test]
fn a_job_is_ground_by_its_own_program() {
    for control in ["linuxcnc", "siemens"] {
        let folder = tempfile::tempdir().unwrap();
        let mut set: Vec<String> =
            ["nc.rough_tolerance_um=2", "nc.path_tolerance_um=10", "work_speed_rpm=20"].map(String::from).to_vec();
        set.push(format!("nc.control={control}"));
        let written = write_program("eccentric", &set, folder.path(), |_| {}).unwrap();
        let own = prepare("eccentric", &set, None).unwrap();
        set.push(format!("program={}", folder.path().join(&written.files[0]).display()));
        let prepared = prepare("eccentric", &set, None).unwrap();
        assert!(prepared.plan_hash() != own.plan_hash() && prepared.job.hash != own.job.hash);
        assert_eq!(prepared.planned.plan.lobes, own.planned.plan.lobes);
        let (_, lobes) = simulate_job(&prepared, &[], |_, _| {}).unwrap();
        let error_m = lobes[0].form_error_max.abs();
        assert!(error_m > 1e-7 && error_m < 3e-6, "{control}: {error_m} m");
    }
}

#[test]
fn programs_that_a_job_cannot_be_ground_by_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.ngc");
    let program = |text: &str| {
        std::fs::write(&path, format!("G21 G17 G90 G94\n{text}\nM2\n")).unwrap();
        format!("program={}", path.display())
    };
    let feeds = "G0 X160 Z80 C0\nG93 G64 P0.05\nG1 X120 C90 F6\nG1 C450 F2\nG1 X160 C540 F6";
    prepare("eccentric", &[program(feeds)], None).unwrap();
    for (text, set, words) in [
        (feeds.replace("C450", "B3"), None, "short.ngc:5"),
        (feeds.replace("C450", "C80"), None, "short.ngc, line 5: the feed turns C from 90 to 80 deg"),
        (feeds.replace("Z80", "Z110"), None, "where no lobe is before the wheel"),
        (feeds.into(), Some("nc.rotation_sense=-1"), "the program is for a rotation sense of -1, this machine's is 1"),
        (feeds.into(), Some("dry_run.stand_off_mm=5"), "dry_run"),
    ] {
        let set: Vec<String> = [program(&text)].into_iter().chain(set.map(String::from)).collect();
        let found = prepare("eccentric", &set, None).unwrap_err().to_string();
        assert!(found.contains(words), "{found}");
    }
    assert!(refusal(&["program=/nowhere/at_all.ngc"]).contains("not found"));
}
