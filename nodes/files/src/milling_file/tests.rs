// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use camwright::job::milling::GrooveKind;

const PLATE: &str = "\
schema: camwright/milling_job/1
name: plate_groove
title: a plate cam with a groove
tool: {number: 3, cuts_with: periphery, radius_mm: 5.0, spindle_rpm: 3000, text: end mill 10 mm}
profiles:
  - name: track
    base_radius_mm: 40.0
    follower: {kind: roller, radius_mm: 8.0}
    lift:
      segments:
        - {law: dwell, angle_deg: 60}
        - {law: 4-5-6-7, angle_deg: 120, rise_mm: 12}
        - {law: dwell, angle_deg: 60}
        - {law: 4-5-6-7, angle_deg: 120, rise_mm: -12}
  - name: disc
    base_radius_mm: 60.0
    follower: {kind: flat}
    lift: {eccentric: {eccentricity_mm: 2}}
cams:
  - {name: A, profile: disc, phase_deg: 90, z_mm: 20}
grooves:
  - {name: G, kind: plate, profile: track, phase_deg: 30, top_mm: 1, depth_mm: 8, step_mm: 2}
passes:
  - {name: rough, leaves_mm: 0.3, work_speed_rpm: 2, tolerance_um: 10, turns: 1}
  - {name: finish, leaves_mm: 0, work_speed_rpm: 4, tolerance_um: 0.5}
";

const BARREL: &str = "\
schema: camwright/milling_job/1
name: barrel
tool: {radius_mm: 5.0, spindle_rpm: 4000}
grooves:
  - name: B
    kind: barrel
    lift:
      segments:
        - {law: cycloidal, angle_deg: 180, rise_mm: 40}
        - {law: cycloidal, angle_deg: 180, rise_mm: -40}
    roller_radius_mm: 10
    outer_radius_mm: 50
    depth_mm: 15
    step_mm: 4
    z_mm: 40
    y_axis: true
passes:
  - {name: finish, leaves_mm: 0, work_speed_rpm: 4, tolerance_um: 1}
";

fn with(text: &str, overrides: &[&str]) -> Result<MilledJob, Vec<String>> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let located = Located::new("job.yaml", text);
    read(&located, &overrides).map_err(|errors| errors.iter().map(ToString::to_string).collect())
}

fn refusal(text: &str, overrides: &[&str]) -> String {
    with(text, overrides).expect_err("it is no job").join("\n")
}

/// The text with one piece replaced, so that lines stay what they are.
fn edited(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn what_is_written_is_what_is_meant() {
    let job = with(PLATE, &[]).unwrap();
    let spec = &job.spec;
    assert_eq!(
        (spec.name.as_str(), job.title.as_str(), job.hash.len()),
        ("plate_groove", "a plate cam with a groove", 64)
    );
    assert_eq!(
        (spec.tool.number, spec.tool.cuts_with, spec.tool.text.as_str()),
        (3, CutsWith::Periphery, "end mill 10 mm")
    );
    assert!((spec.tool.spindle_speed_rad_s - 100.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!((spec.clearance_mm - 2.0).abs() < 1e-15, "left out");
    let cam = &spec.cams[0];
    assert!((cam.phase_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-15 && (cam.z_mm - 20.0).abs() < 1e-15);
    assert_eq!((cam.name.as_str(), cam.width_mm), ("A", None));
    let groove = &spec.grooves[0];
    assert_eq!(groove.steps_mm(), [6.0, 4.0, 2.0, 0.0]);
    let GrooveKind::Plate { groove: walls, top_mm, .. } = &groove.kind else { panic!("{:?}", groove.kind) };
    assert!((*top_mm - 1.0).abs() < 1e-15 && (walls.roller_radius_mm() - 8.0).abs() < 1e-15);
    let passes: Vec<_> = spec.passes.iter().map(|pass| (pass.name.as_str(), pass.turns)).collect();
    assert_eq!(passes, [("rough", 1), ("finish", 1)]);
    assert!((spec.passes[0].tolerance_mm - 0.01).abs() < 1e-15 && (spec.passes[0].leaves_mm - 0.3).abs() < 1e-15);
    assert_eq!(job.lifts.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["track", "disc"]);

    let job = with(BARREL, &[]).unwrap();
    assert_eq!((job.spec.tool.number, job.spec.tool.cuts_with), (1, CutsWith::Periphery), "left out");
    let groove = &job.spec.grooves[0];
    let GrooveKind::Barrel { groove: walls, z_mm, y_axis } = &groove.kind else { panic!("{:?}", groove.kind) };
    assert!((walls.floor_radius_mm() - 35.0).abs() < 1e-12 && (*z_mm - 40.0).abs() < 1e-15 && *y_axis);
    assert_eq!((groove.steps_mm().len(), job.lifts[0].0.as_str()), (4, "B"));
}

#[test]
fn a_job_without_steps_goes_down_at_once_and_without_y_turns_c() {
    let text = edited(&edited(BARREL, "    step_mm: 4\n", ""), "    y_axis: true\n", "");
    let groove = &with(&text, &[]).unwrap().spec.grooves[0];
    assert_eq!(groove.steps_mm(), [0.0]);
    assert!(matches!(groove.kind, GrooveKind::Barrel { y_axis: false, .. }));
}

#[test]
fn every_number_is_refused_outside_its_range_with_its_line() {
    for (key, values) in [
        ("tool.radius_mm", &["-5", "0", "1e9"][..]),
        ("tool.spindle_rpm", &["0", "-1", "1e7"]),
        ("tool.number", &["0", "10000"]),
        ("clearance_mm", &["0", "-2"]),
        ("cams.0.z_mm", &["1e6", "-1e6"]),
        ("cams.0.phase_deg", &["1e9"]),
        ("cams.0.width_mm", &["0", "-1"]),
        ("grooves.0.depth_mm", &["0", "-8", "1e9"]),
        ("grooves.0.step_mm", &["0", "-8"]),
        ("grooves.0.top_mm", &["1e9"]),
        ("grooves.0.phase_deg", &["-1e9"]),
        ("passes.0.leaves_mm", &["-0.1", "1e6"]),
        ("passes.0.work_speed_rpm", &["0", "-1", "1e6"]),
        ("passes.0.tolerance_um", &["0", "-1", "1e6"]),
        ("passes.0.turns", &["0", "101"]),
    ] {
        for value in values {
            let found = refusal(PLATE, &[&format!("{key}={value}")]);
            let name = key.rsplit('.').next().unwrap();
            assert!(found.contains(&format!("{name} is ")) && found.contains(" must be "), "{key}={value}: {found}");
        }
    }
    // What is no number at all, on its own line.
    for (piece, line) in [
        ("radius_mm: 5.0", 4),
        ("spindle_rpm: 3000", 4),
        ("z_mm: 20", 20),
        ("phase_deg: 90", 20),
        ("depth_mm: 8", 22),
        ("step_mm: 2", 22),
        ("top_mm: 1", 22),
        ("leaves_mm: 0.3", 24),
        ("work_speed_rpm: 2", 24),
        ("tolerance_um: 10", 24),
    ] {
        for value in [".nan", ".inf", "-.inf"] {
            let key = piece.split(':').next().unwrap();
            let found = refusal(&edited(PLATE, piece, &format!("{key}: {value}")), &[]);
            assert!(found.starts_with(&format!("job.yaml:{line}: non-finite float")), "{found}");
        }
    }
    let negative = edited(PLATE, "radius_mm: 5.0", "radius_mm: -5.0");
    assert_eq!(refusal(&negative, &[]), "job.yaml:4: tool.radius_mm is -5; it must be 0.000001 to 1000");
    let steps = edited(PLATE, "step_mm: 2", "step_mm: 0.001");
    assert_eq!(
        refusal(&steps, &[]),
        "job.yaml:22: groove G: step_mm is 0.001, which takes 8000 steps down; at most 1000 are allowed"
    );
}

#[test]
fn keys_of_the_other_kind_and_missing_ones_are_refused() {
    let error = refusal(PLATE, &["grooves.G.roller_radius_mm=8", "grooves.G.y_axis=true"]);
    for key in ["roller_radius_mm", "y_axis"] {
        assert!(
            error.contains(&format!("groove G: {key} is about a groove of kind barrel; this one is of kind plate")),
            "{error}"
        );
    }
    let missing = refusal(&edited(PLATE, "profile: track, ", ""), &[]);
    assert_eq!(missing, "job.yaml:22: groove G: a groove of kind plate needs profile");
    let missing = refusal(
        &edited(&edited(BARREL, "    z_mm: 40\n", ""), "    outer_radius_mm: 50\n", ""),
        &["grooves.B.top_mm=0"],
    );
    assert!(missing.contains("groove B: a groove of kind barrel needs z_mm"), "{missing}");
    assert!(missing.contains("groove B: a groove of kind barrel needs outer_radius_mm"), "{missing}");
    assert!(
        missing.contains("groove B: top_mm is about a groove of kind plate; this one is of kind barrel"),
        "{missing}"
    );
    assert!(refusal(PLATE, &["tool.diameter_mm=10"]).contains("diameter_mm"), "an unknown key");
    assert!(refusal(PLATE, &["grooves.G.kind=spiral"]).contains("spiral"));
    assert!(
        refusal(PLATE, &["profiles.track.gauge={kind: flat}"])
            .contains("gauge is for ground lobes; remove it from a milled part")
    );
    assert!(refusal(PLATE, &["schema=camwright/milling_job/7"]).contains("is of schema version 7"));
}

#[test]
fn a_job_needs_something_to_make_under_names_that_differ() {
    assert!(refusal(PLATE, &["passes=[]"]).contains("passes has 0 entries; it must have 1 to 100"));
    assert!(
        refusal(PLATE, &["cams=[]", "grooves=[]"])
            .contains("the job has neither cams nor grooves; it needs at least 1")
    );
    assert!(refusal(PLATE, &["cams.A.name=G"]).contains("there are two cams or grooves named G; names must differ"));
    assert!(
        refusal(PLATE, &["passes.rough.name=finish"]).contains("there are two passes named finish; names must differ")
    );
    assert!(
        refusal(PLATE, &["cams.A.name=a)b"])
            .contains("cams.0.name is \"a)b\"; it must be 1 to 64 letters, digits, '_' and '-'")
    );
    let unknown = refusal(&edited(PLATE, "profile: disc", "profile: disk"), &[]);
    assert_eq!(unknown, "job.yaml:20: there is no profile disk; the job has track, disc");
    assert!(refusal(PLATE, &["grooves.G.profile=none"]).contains("there is no profile none; the job has track, disc"));
    let many: Vec<String> = (0..101).map(|i| format!("{{name: c{i}, profile: disc, z_mm: 0}}")).collect();
    let error = refusal(PLATE, &[&format!("cams=[{}]", many.join(", "))]);
    assert!(error.contains("cams has 101 entries; it must have at most 100 (set by cams="), "{error}");
}

/// Flanks of the track over so many degrees.
fn flanks(angle_deg: f64) -> String {
    let dwell = 180.0 - angle_deg;
    format!(
        "profiles.track.lift.segments=[{{law: dwell, angle_deg: {dwell}}}, {{law: 4-5-6-7, angle_deg: {angle_deg}, rise_mm: 12}}, \
         {{law: dwell, angle_deg: {dwell}}}, {{law: 4-5-6-7, angle_deg: {angle_deg}, rise_mm: -12}}]"
    )
}

/// One mill, and what it cannot do, with the pass in which it cannot.
#[test]
fn a_mill_that_does_not_suit_is_refused_with_figures() {
    let wide = refusal(&edited(PLATE, "radius_mm: 5.0", "radius_mm: 8.0"), &[]);
    assert!(wide.starts_with("job.yaml:4: groove G, pass rough: a mill of radius 8 mm does not go into the groove, whose half width is 7.7 mm"), "{wide}");
    let tiny = refusal(PLATE, &["tool.radius_mm=1e-6"]);
    assert!(tiny.contains("paths beside each other"), "{tiny}");
    // Only the first pass has to cut from the full.
    let fine = edited(PLATE, "radius_mm: 5.0", "radius_mm: 0.2");
    assert!(with(&fine, &[]).is_ok());
    let hollow = refusal(PLATE, &["tool.cuts_with=face", "grooves=[]", "cams.A.profile=track", &flanks(50.0)]);
    assert!(hollow.contains("cam A, pass rough: the contour is hollow at cam angle"), "{hollow}");
    let small = refusal(PLATE, &["tool.cuts_with=face", "grooves=[]", "tool.radius_mm=1.5"]);
    assert!(
        small.contains("cam A, pass rough: a face of radius 1.5 mm touches the contour 2.000 mm beside its middle"),
        "{small}"
    );
    let narrow = refusal(PLATE, &["tool.cuts_with=face", "grooves=[]", "cams.A.width_mm=12"]);
    assert!(narrow.contains("cuts 9.165 mm along Z; the cam is 12 mm wide"), "{narrow}");
    let large = refusal(PLATE, &["cams.A.profile=track", "grooves=[]", "tool.radius_mm=900", &flanks(50.0)]);
    assert!(
        large.contains("cam A, pass rough: the wheel of radius 900.300 mm does not reach into the concave flank"),
        "{large}"
    );
}

#[test]
fn the_axis_of_the_mill_lies_one_way() {
    let face = refusal(PLATE, &["tool.cuts_with=face"]);
    assert_eq!(
        face,
        "job.yaml:22: the mill's axis is radial for cam A and parallel to the part's for groove G; a job has one mill, whose axis lies one way"
    );
    assert!(with(PLATE, &["tool.cuts_with=face", "grooves=[]"]).is_ok());
    assert!(with(PLATE, &["tool.cuts_with=face", "cams=[]"]).is_ok(), "it is about cams");
}

#[test]
fn what_is_no_groove_is_refused_with_the_line_of_its_profile_or_lift() {
    let follower = refusal(&edited(PLATE, "{kind: roller, radius_mm: 8.0}", "{kind: flat}"), &[]);
    assert_eq!(
        follower,
        "job.yaml:8: groove G: profile track: a groove guides a roller, on a slide or on an arm; this follower is none"
    );
    let undercut = refusal(PLATE, &[&flanks(20.0)]);
    assert!(
        undercut.contains("groove G: profile track: the inner wall of the groove: undercut at cam angle "),
        "{undercut}"
    );
    let steep = "grooves.B.lift.segments=[{law: cycloidal, angle_deg: 20, rise_mm: 30}, {law: dwell, angle_deg: 160}, \
                 {law: cycloidal, angle_deg: 20, rise_mm: -30}, {law: dwell, angle_deg: 160}]";
    let steep = refusal(BARREL, &[steep]);
    assert!(steep.contains("groove B: the groove is undercut at its "), "{steep}");
    assert!(
        refusal(BARREL, &["grooves.B.depth_mm=50"]).contains("depth_mm is 50; it must stay below outer_radius_mm, 50")
    );
    assert!(
        refusal(BARREL, &["grooves.B.depth_mm=46"])
            .contains("the radius of the floor is 4 mm, it must be larger than half that of the roller")
    );
    assert!(refusal(BARREL, &["grooves.B.lift={eccentric: {eccentricity_mm: 3}}"]).contains("needs a follower"));
    assert!(refusal(BARREL, &["grooves.B.lift={}"]).contains("lift needs exactly one of"));
}

/// Ten million rows are not read to the end.
#[test]
fn a_table_that_is_far_too_long_is_refused_by_its_size_or_at_the_row_too_many() {
    let folder = tempfile::tempdir().unwrap();
    let table = |name: &str, rows: u32| {
        let path = folder.path().join(name);
        let text = (0..rows).fold(String::from("cam_angle_deg,lift_mm\n"), |text, _| text + "0,0\n");
        std::fs::write(&path, text).unwrap();
        let lift = format!("profiles.track.lift={{table: {:?}}}", path.display().to_string());
        refusal(PLATE, &[&lift])
    };
    let long = table("long.csv", 100_000);
    assert!(long.contains("long.csv:36003: is a row too many: a table has at most 36001"), "{long}");
    let longer = table("longer.csv", 10_000_000);
    assert!(longer.contains("has 40000022 bytes, at most 16777216 are read"), "{longer}");
}

/// Bytes omitted, put in or changed, wherever: an answer, and no more than a moment for it.
#[test]
fn no_text_makes_the_reader_panic() {
    let (mut read_well, mut refused) = (0, 0);
    for seed in 0..400_u64 {
        // SplitMix64: the same texts everywhere.
        let mut state = seed;
        let mut random = |below: usize| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            usize::try_from((z ^ (z >> 31)) % below as u64).expect("a small number")
        };
        let mut text = if random(2) == 0 { PLATE.as_bytes().to_vec() } else { BARREL.as_bytes().to_vec() };
        // Half of them get other figures alone, of which many are a job.
        let figures: Vec<usize> = (0..text.len()).filter(|at| text[*at].is_ascii_digit()).collect();
        if random(2) == 0 {
            for _ in 0..=random(3) {
                text[figures[random(figures.len())]] = b"0123456789"[random(10)];
            }
        }
        for _ in 0..random(3) {
            let (at, with) = (random(text.len()), b"0123456789.-e:, {}[]\n#x"[random(23)]);
            match random(3) {
                0 => drop(text.remove(at)),
                1 => text.insert(at, with),
                _ => text[at] = with,
            }
        }
        let text = String::from_utf8(text).expect("ASCII stays ASCII");
        match with(&text, &[]) {
            Ok(job) => {
                read_well += 1;
                assert!(job.spec.grooves.iter().all(|groove| groove.steps_mm().len() <= 1000), "seed {seed}");
            }
            Err(errors) => {
                refused += 1;
                assert!(
                    !errors.is_empty() && errors.iter().all(|error| error.starts_with("job.yaml")),
                    "seed {seed}: {errors:?}"
                );
            }
        }
    }
    assert!(read_well > 40 && refused > 100, "{read_well} read, {refused} refused");
}

const LEVEL_WIND: &str = include_str!("../../../../params/jobs/level_wind.yaml");
const INDEXER: &str = include_str!("../../../../params/jobs/barrel_indexer.yaml");

#[test]
fn a_groove_runs_over_several_turns_or_between_two_ends() {
    let wind = with(LEVEL_WIND, &[]).unwrap();
    let GrooveKind::Barrel { groove, z_mm, .. } = &wind.spec.grooves[0].kind else { panic!("no barrel") };
    assert_eq!((groove.course().turns(), groove.course().is_open(), wind.lifts[0].0.as_str()), (6, false, "W"));
    let middle = groove.course().centre(rad_from_deg(1080.0));
    assert!((middle.z.value - 51.0).abs() < 1e-9 && (*z_mm - 20.0).abs() < 1e-12, "{middle:?}");
    assert!((wind.lifts[0].1.law.max_lift_mm() - 51.0).abs() < 1e-9);

    let indexer = with(INDEXER, &[]).unwrap();
    let GrooveKind::Barrel { groove, .. } = &indexer.spec.grooves[0].kind else { panic!("no barrel") };
    let course = groove.course();
    assert_eq!((course.turns(), course.is_open(), indexer.lifts.len()), (3, true, 0));
    // Two stations of 30 deg from -45 deg: the dwell at 15 deg on a radius of 80 mm.
    let dwell = course.centre(rad_from_deg(720.0));
    let (sin, cos) = rad_from_deg(15.0).sin_cos();
    assert!((dwell.z.value - 80.0 * sin).abs() < 1e-9 && (dwell.y.value - 76.0 + 80.0 * cos).abs() < 1e-9, "{dwell:?}");
    assert!(dwell.z.first.abs() < 1e-9);

    // A roller on a slide, with ends.
    let slide = INDEXER.replace("rise_deg: 30.0", "rise_mm: 41.0");
    let slide = edited(&slide, "    turret: {stations: 12, radius_mm: 80.0, axis_y_mm: 76.0, start_deg: -45.0}\n", "");
    let slide = edited(&slide, "z_mm: 50.0", "z_mm: -12.0");
    let job = with(&slide, &["grooves.0.y_axis=false"]).unwrap();
    let GrooveKind::Barrel { groove, .. } = &job.spec.grooves[0].kind else { panic!("no barrel") };
    assert!((groove.course().lift(100.0).value - 123.0).abs() < 1e-9);
}

#[test]
fn what_is_no_groove_of_several_turns_or_with_ends_is_refused_at_its_line() {
    let wind = |key: &str| refusal(LEVEL_WIND, &[key]);
    let indexer = |from: &str, to: &str| refusal(&edited(INDEXER, from, to), &[]);
    for (found, words) in [
        (wind("grooves.0.turns=5"), "groove W: the segments cover 2160.000000 deg, 5 turns are 1800 deg"),
        (wind("grooves.0.turns=51"), "turns is 51; it must be 1 to 50"),
        (wind("grooves.0.turns=0"), "turns is 0; it must be 1 to 50"),
        (
            wind("grooves.0.lift={eccentric: {eccentricity_mm: 5}}"),
            "turns is 6; a lift over several turns is stated by segments",
        ),
        (wind("grooves.0.to_mm=null"), "from_mm needs to_mm, the other end face"),
        (wind("grooves.0.from_mm=null"), "to_mm needs from_mm, the other end face"),
        (wind("grooves.0.to_mm=-5"), "to_mm is -5; it must be above from_mm, 0"),
        (wind("grooves.0.from_mm=17"), "the groove leaves the cylinder: its walls reach from Z 16.000 to 75.000 mm"),
        (wind("grooves.0.may_cross=false"), "groove W: the groove crosses itself at azimuth"),
        (
            refusal(BARREL, &["grooves.0.may_cross=true"]),
            "may_cross is about a groove of several turns for a follower on a slide",
        ),
        (indexer("y_axis: true", "y_axis: true\n    may_cross: true"), "may_cross is about a groove of several turns"),
        (
            indexer("    from_mm: 18.0\n    to_mm: 82.0\n", ""),
            "an open groove needs the end faces of the cylinder, from_mm and to_mm",
        ),
        (
            refusal(BARREL, &["grooves.0.turret={stations: 12, radius_mm: 80, axis_y_mm: 76}"]),
            "a turret needs the end faces of the cylinder, from_mm and to_mm",
        ),
        (wind("grooves.0.roller_radius_mm=9.1"), "groove W: the rib between its turns vanishes at azimuth"),
        (
            wind("grooves.0.lift.segments.4.rise_mm=-47"),
            "after 6 turns 1.000000000 mm of lift remain; allowed: 1e-9 mm; `open: true`",
        ),
        (wind("grooves.0.lift.segments.0.rise_deg=1"), "one is needed"),
        (refusal(PLATE, &["grooves.0.turns=2"]), "turns is about a groove of kind barrel; this one is of kind plate"),
        (refusal(PLATE, &["grooves.0.open=true"]), "open is about a groove of kind barrel"),
        (
            refusal(BARREL, &["grooves.0.kind=globoid"]),
            "groove B: globoid cams are not supported: their mill swings about the axis of the turret; supported are grooves round a cylinder",
        ),
        (
            refusal(BARREL, &["grooves.0.open=true"]),
            "an open groove needs the end faces of the cylinder, from_mm and to_mm",
        ),
        (indexer("    open: true\n", ""), "after 3 turns"),
        (
            indexer("    y_axis: true\n", ""),
            "the roller of a turret moves across the part; this takes a machine with a Y axis",
        ),
        (indexer("y_axis: true", "y_axis: false"), "this takes a machine with a Y axis"),
        (
            indexer("stations: 12", "stations: 11"),
            "the lift turns the turret by 30.000000 deg from azimuth 0.00 deg to the same place a turn later; with 11 stations",
        ),
        (indexer("stations: 12, ", ""), "stations"),
        (indexer("radius_mm: 80.0, axis_y_mm", "radius_mm: -1, axis_y_mm"), "turret.radius_mm is -1"),
        (indexer("axis_y_mm: 76.0", "axis_y_mm: 20.0"), "the roller stands"),
        (indexer("start_deg: -45.0", "start_deg: 20.0"), "it must stay below 90 deg on either side"),
        (
            indexer("from_mm: 18.0", "from_mm: 3.0"),
            "groove I: the open groove begins at Z -6.569 mm, inside the cylinder or too near",
        ),
        (indexer("to_mm: 82.0", "to_mm: 97.0"), "the open groove ends at Z 106.569 mm"),
        (
            indexer("      repeat: 3\n", "      repeat: 3\n      start_deg: 5\n"),
            "start_deg is 5; an open groove begins with its first segment",
        ),
        (indexer("      repeat: 3\n", "      repeat: 2\n"), "the segments cover 720.000000 deg, 3 turns are 1080 deg"),
        (
            indexer("law: dwell, angle_deg: 90", "law: constant_velocity, rise_deg: 1, angle_deg: 90"),
            "segment 1 (constant_velocity) begins with",
        ),
    ] {
        assert!(found.starts_with("job.yaml:") || found.contains("--set"), "{found}");
        assert!(found.contains(words), "{words}: {found}");
        assert_eq!(found.lines().count(), 1, "{found}");
    }
    // Its own line.
    let found = indexer("stations: 12", "stations: 11");
    assert!(found.starts_with("job.yaml:14: groove I: "), "{found}");
    let found = indexer("    open: true\n", "    open: true\n    phase_deg: 10\n    depth: 3\n");
    assert!(found.contains("job.yaml:13:") && found.contains("depth"), "{found}");
    let second = edited(
        BARREL,
        "passes:",
        "  - {name: C, kind: barrel, lift: {round: true}, roller_radius_mm: 10, outer_radius_mm: 50, depth_mm: 15, z_mm: 95, y_axis: true}\npasses:",
    );
    let found = refusal(&second, &[]);
    assert!(found.starts_with("job.yaml:17: the rib between grooves C and B vanishes"), "{found}");
    assert!(with(&second, &["grooves.1.z_mm=101"]).is_ok());
}
