// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use camwright::cam::follower::{ArmSide, Pivot, SwingLift};
use camwright::math::units::rad_from_deg;
use std::f64::consts::TAU;
use tempfile::TempDir;

/// Lift of the tests over the cam angle: a raised cosine of 6 mm over the whole turn, nose at 180 deg.
fn lift_mm(cam_deg: f64) -> f64 {
    3.0 - 3.0 * (cam_deg * TAU / 360.0).cos()
}

/// A lobe with a base circle: 6 mm over 60 deg on either side of the nose, (1 − u²)⁴.
fn lobe_mm(from_nose_deg: f64) -> f64 {
    let u = from_nose_deg / 60.0;
    if u.abs() < 1.0 { 6.0 * (1.0 - u * u).powi(4) } else { 0.0 }
}

/// 72 rows of a turn, each printed by `row` from its cam angle and lift.
fn turn(row: impl Fn(f64, f64) -> String) -> String {
    (0..72).map(|k| row(5.0 * f64::from(k), lift_mm(5.0 * f64::from(k))) + "\n").collect()
}

/// Rows of a flank from the nose down, one per degree.
fn flank(row: impl Fn(f64, f64) -> String) -> String {
    (0..=70).map(|k| row(f64::from(k), lobe_mm(f64::from(k))) + "\n").collect()
}

/// Files in a folder of their own, read as the `lift` of a job beside them.
struct Folder(TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        for (file, text) in files {
            std::fs::write(folder.path().join(file), text).expect("a file in it");
        }
        Self(folder)
    }

    /// Reads the `lift` mapping in YAML flow form.
    fn read(&self, lift: &str) -> Result<ProfileLift, Vec<String>> {
        self.read_for(lift, Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 })
    }

    /// The same for a follower.
    fn read_for(&self, lift: &str, follower: Follower) -> Result<ProfileLift, Vec<String>> {
        let text = format!("lift: {lift}\n");
        let path = self.0.path().join("job.yaml");
        let document = Document::parse(&path, &text, &[]).expect("YAML");
        #[derive(Deserialize, JsonSchema)]
        struct Profile {
            lift: LiftFile,
        }
        let error_text = |error: ConfigError| error.to_string().replace(&format!("{}/", self.0.path().display()), "");
        let file: Profile =
            schema::read(&document).map_err(|errors| errors.into_iter().map(error_text).collect::<Vec<_>>())?;
        let profile = LiftContext {
            document: &document,
            key: "lift",
            name: "p",
            follower: Some((follower, 16.0)),
            before: &[],
            groove: None,
        };
        read(&file.lift, profile, &mut JobFiles::from_document(profile.document))
            .map_err(|errors| errors.into_iter().map(error_text).collect())
    }
}

/// Reads one file `t.txt` under a `lift` that names it.
fn read_one(text: &str, lift: &str) -> Result<ProfileLift, Vec<String>> {
    Folder::new(&[("t.txt", text)]).read(lift)
}

/// Every lift of the table within half a digit of the formula.
fn is_the_turn(lift: &ProfileLift, digit_mm: f64) {
    let table = lift.table.as_ref().expect("a table");
    assert_eq!(table.blocks(), 72);
    for block in 0..72 {
        let wanted = lift_mm(5.0 * block as f64);
        assert!((table.lift_mm(block) - wanted).abs() <= 0.500_001 * digit_mm, "{block}: {}", table.lift_mm(block));
    }
    assert_eq!(lift.warnings, []);
}

#[test]
fn commas_semicolons_tabs_and_blanks_separate_columns() {
    for separator in [",", ";", "\t", "  ", " , "] {
        let rows = turn(|angle, lift| format!("{angle:.1}{separator}{lift:.3}"));
        let text = format!("# a comment\n\ncam_angle_deg{separator}lift_mm\n{rows}");
        is_the_turn(&read_one(&text, "{table: t.txt}").unwrap(), 1e-3);
    }
}

#[test]
fn decimal_commas_are_read_where_they_are_declared() {
    let comma = |x: f64, digits: usize| format!("{x:.digits$}").replace('.', ",");
    let semicolons = turn(|angle, lift| format!("{};{}", comma(angle, 1), comma(lift, 3)));
    let text = format!("cam_angle_deg;lift_mm\n{semicolons}");
    is_the_turn(&read_one(&text, "{table: t.txt, decimal_comma: true}").unwrap(), 1e-3);
    let tabs = turn(|angle, lift| format!("{}\t{}", comma(angle, 1), comma(lift, 3)));
    let lift = "{table: t.txt, decimal_comma: true, columns: [cam_angle_deg, lift_mm]}";
    is_the_turn(&read_one(&tabs, lift).unwrap(), 1e-3);
    // One column: nothing separates, so every comma is a decimal one.
    let column = turn(|_, lift| comma(lift, 3));
    let lift = "{table: t.txt, decimal_comma: true, columns: [lift_mm], step_cam_deg: 5}";
    is_the_turn(&read_one(&column, lift).unwrap(), 1e-3);
    // Without a declaration one error shows the declaration to add.
    let errors = read_one(&text, "{table: t.txt}").unwrap_err();
    assert_eq!(
        errors,
        ["t.txt:2: \"0,0\" has a decimal comma, as have 143 others; the job must declare `decimal_comma: true`"]
    );
    let errors = read_one(&text.replace("cam_angle_deg;lift_mm", "Winkel;Hub (Zoll)"), "{table: t.txt}").unwrap_err();
    let example = "`lift: {table: t.txt, columns: [cam_angle_deg, lift_inch], decimal_comma: true}`";
    assert!(errors.len() == 1 && errors[0].contains(example), "{errors:?}");
    // Declared, and not so.
    let points = format!("cam_angle_deg;lift_mm\n{}", turn(|angle, lift| format!("{angle:.0};{lift:.3}")));
    let errors = read_one(&points, "{table: t.txt, decimal_comma: true}").unwrap_err();
    assert_eq!(errors[0], "t.txt:2: \"0.000\" has a decimal point, the job declares decimal commas");
}

#[test]
fn titles_and_comments_of_other_programs_are_passed_over() {
    let rows = turn(|angle, lift| format!("{angle:.1}\t{lift:.4}\t{:.1}", 0.0));
    let text = format!(
        "\u{feff}LIFT TABLE 4711\r\n! made by a program\r\n% and another\r\n* and more\r\n// of them\r\nAngle\tTravel\tRamp\r\n{}",
        rows.replace('\n', "\r\n").replacen("\r\n", " # the base centre\r\n", 1)
    );
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_mm, \"-\"]}";
    is_the_turn(&read_one(&text, lift).unwrap(), 1e-4);
    // Titles that begin with numbers are counted off.
    let numbered = format!("4711 12 0\n72 rows\n{rows}");
    let lift = "{table: t.txt, header_lines: 2, columns: [cam_angle_deg, lift_mm, \"-\"]}";
    is_the_turn(&read_one(&numbered, lift).unwrap(), 1e-4);
    // A line of units under the header.
    let units = format!("cam_angle_deg,lift_mm\n(deg),(mm)\n{}", turn(|angle, lift| format!("{angle:.1},{lift:.3}")));
    is_the_turn(&read_one(&units, "{table: t.txt}").unwrap(), 1e-3);
    // The columns have no names.
    let errors = read_one(&rows, "{table: t.txt}").unwrap_err();
    assert!(errors[0].starts_with("t.txt:1: no header line names the columns; the job must"), "{errors:?}");
    let errors = read_one(&text, "{table: t.txt}").unwrap_err();
    assert!(errors[0].starts_with("t.txt:6: unknown column \"Angle\"; name the columns in the job"), "{errors:?}");
}

/// Rows in descending order, rows between bars, and angles that count against the cam are the same turn.
#[test]
fn descending_and_mirrored_rows_and_bars_are_the_same_turn() {
    let rows = turn(|angle, lift| format!("{angle:.1} | {lift:.4}"));
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_mm]}";
    is_the_turn(&read_one(&rows, lift).unwrap(), 1e-4);
    let descending: Vec<&str> = rows.lines().rev().collect();
    is_the_turn(&read_one(&descending.join("\n"), lift).unwrap(), 1e-4);
    // The nose of this table stands 30 deg early; seen from the other end 30 deg late.
    let early = turn(|angle, _| format!("{angle:.1} {:.4}", lift_mm(angle + 30.0)));
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_mm], mirrored: true, zero_deg: -30}";
    is_the_turn(&read_one(&early, lift).unwrap(), 1e-4);
    is_the_turn(&read_one(&early, "{table: t.txt, columns: [cam_angle_deg, lift_mm], zero_deg: 30}").unwrap(), 1e-4);
    let errors = read_one(&rows, "{half_table: t.txt, mirrored: true}").unwrap_err();
    assert!(errors[0].contains("mirrored is about a whole table"), "{errors:?}");
    let errors = read_one(&rows.replacen("\n5.0", "\n12.0", 1), lift).unwrap_err();
    assert!(errors.iter().any(|error| error.contains("t.txt:3")), "rows in no order are refused: {errors:?}");
}

#[test]
fn one_column_needs_its_step_and_keeps_it() {
    let rows = turn(|_, lift| format!("{lift:.3}"));
    let declared = "{table: t.txt, columns: [lift_mm], step_cam_deg: 5}";
    is_the_turn(&read_one(&rows, declared).unwrap(), 1e-3);
    is_the_turn(&read_one(&rows, "{table: t.txt, columns: [lift_mm], step_crank_deg: 10}").unwrap(), 1e-3);
    let errors = read_one(&rows, "{table: t.txt, columns: [lift_mm], step_crank_deg: 5}").unwrap_err();
    assert_eq!(
        errors,
        [
            "t.txt:72: the table covers 360.00 deg where one turn of the cam is 720 deg of the crank: these are cam degrees, \
             declared are crank degrees; declare cam degrees, or `event_only: true` if only the base circle is missing"
        ]
    );
    let errors = read_one(&rows, "{table: t.txt, columns: [lift_mm], step_cam_deg: 10}").unwrap_err();
    assert_eq!(
        errors,
        [
            "t.txt:37: the table covers 720.00 deg where one turn of the cam is 360 deg: these are crank degrees, declared \
             are cam degrees; declare crank degrees"
        ]
    );
    let two = turn(|angle, lift| format!("{angle:.1},{lift:.3}"));
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_mm], step_cam_deg: 5}";
    let errors = read_one(&two, lift).unwrap_err();
    assert_eq!(errors, ["t.txt:1: the table has a column of angles, and the job declares a step as if it had none"]);
}

#[test]
fn crank_degrees_inches_and_micrometres_are_declared_by_the_columns() {
    let crank = format!("crank_angle_deg,lift_mm\n{}", turn(|angle, lift| format!("{:.1},{lift:.3}", 2.0 * angle)));
    is_the_turn(&read_one(&crank, "{table: t.txt, angle: crank}").unwrap(), 1e-3);
    let errors = read_one(&crank, "{table: t.txt}").unwrap_err();
    assert_eq!(errors, ["t.txt:1: column crank_angle_deg, but the job declares cam_angle_deg"]);
    let errors = read_one(&crank, "{table: t.txt, columns: [cam_angle_deg, lift_mm]}").unwrap_err();
    assert_eq!(errors, ["t.txt:1: column crank_angle_deg, but the job declares cam_angle_deg"]);
    let inch = turn(|angle, lift| format!("{angle:.1} {:.4}", lift / 25.4));
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_inch]}";
    is_the_turn(&read_one(&inch, lift).unwrap(), 25.4e-4);
    let um = turn(|angle, lift| format!("{angle:.1} {:.0}", lift * 1e3));
    is_the_turn(&read_one(&um, "{table: t.txt, columns: [cam_angle_deg, lift_um]}").unwrap(), 1e-3);
    let increments = turn(|angle, lift| {
        let units = |mm: f64| (mm * 1e3).round() / 25.4;
        format!("{:.12}", (units(lift_mm(angle + 5.0)) - units(lift)) / 1e3)
    });
    let lift = "{table: t.txt, columns: [increment_inch], step_cam_deg: 5, resolution_mm: 0.001}";
    is_the_turn(&read_one(&increments, lift).unwrap(), 1e-3);
    // The figures of an inch table read as millimetres are a suspiciously small cam, and so the other way round.
    let mm = read_one(&inch, "{table: t.txt, columns: [cam_angle_deg, lift_mm]}").unwrap();
    let text = mm.warnings[0].to_string();
    assert!(text.contains("the largest lift is 0.2362 mm") && text.contains("5.999 mm"), "{text}");
    let mm_rows = turn(|angle, lift| format!("{angle:.1} {lift:.3}"));
    let giant = read_one(&mm_rows, "{table: t.txt, columns: [cam_angle_deg, lift_inch]}").unwrap();
    let text = giant.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(text.contains("152.400 mm") && text.contains("2 times its radius"), "{text}");
    // And a file that says so itself.
    let commented = format!("# lift in inches\n{inch}");
    let commented = read_one(&commented, "{table: t.txt, columns: [cam_angle_deg, lift_mm]}").unwrap();
    let text = commented.warnings[0].to_string();
    assert!(text.ends_with("t.txt:1: the file says \"inches\" here, declared are millimetres"), "{text}");
}

#[test]
fn a_table_may_have_its_zero_anywhere() {
    let rows = turn(|angle, _| format!("{angle:.1},{:.3}", lift_mm(angle + 180.0)));
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_mm], zero_deg: 180}";
    is_the_turn(&read_one(&rows, lift).unwrap(), 1e-3);
    let lift = "{table: t.txt, columns: [cam_angle_deg, lift_mm], zero_deg: 181}";
    let errors = read_one(&rows, lift).unwrap_err();
    assert_eq!(
        errors,
        [
            "job.yaml:1: profile p: the file's angle 0 stands at 181 cam deg, 1.000000 deg off a multiple of the step of \
          5.000000 deg"
        ]
    );
}

#[test]
fn a_half_table_is_mirrored_and_two_are_joined() {
    let one = flank(|angle, lift| format!("{angle:.1} {lift:.4}"));
    let is_the_lobe = |lift: &ProfileLift, digit: f64| {
        let table = lift.table.as_ref().expect("a table");
        assert_eq!((table.blocks(), lift.warnings.len()), (360, 0));
        for block in 0..360 {
            let wanted = lobe_mm(block as f64 - 180.0);
            assert!((table.lift_mm(block) - wanted).abs() <= 0.500_001 * digit, "{block}: {}", table.lift_mm(block));
        }
    };
    let lift = "{half_table: t.txt, columns: [cam_angle_deg, lift_mm]}";
    is_the_lobe(&read_one(&one, lift).unwrap(), 1e-4);
    let column = flank(|_, lift| format!("{:.5}", lift / 25.4));
    let lift = "{half_table: t.txt, columns: [lift_inch], step_crank_deg: 2}";
    is_the_lobe(&read_one(&column, lift).unwrap(), 25.4e-5);
    let errors = read_one(&column, "{half_table: t.txt, columns: [lift_inch]}").unwrap_err();
    assert_eq!(errors, ["t.txt: a half table without angles needs its step declared: step_cam_deg or step_crank_deg"]);
    let files = [("open.txt", one.as_str()), ("close.txt", one.as_str())];
    let columns = "columns: [cam_angle_deg, lift_mm]";
    let folder = Folder::new(&files);
    let both = format!("{{opening_table: open.txt, closing_table: close.txt, {columns}}}");
    is_the_lobe(&folder.read(&both).unwrap(), 1e-4);
    let errors = folder.read(&format!("{{opening_table: open.txt, {columns}}}")).unwrap_err();
    assert_eq!(errors, ["job.yaml:1: profile p: opening_table needs a closing_table"]);
    // A fault in either file is reported with its own line.
    let line = |text: &str, index: usize| text.lines().nth(index).expect("a row").to_owned();
    let stray = one.replace(&line(&one, 30), "30.0 3.0000");
    let cut = one.replace(&format!("{}\n", line(&one, 40)), "");
    let folder = Folder::new(&[("open.txt", stray.as_str()), ("close.txt", cut.as_str())]);
    let errors = folder.read(&both).unwrap_err();
    assert_eq!(errors, ["close.txt:41: 1 block(s) missing, the next should be at 40.0000 deg, not 41.0000 deg"]);
    let folder = Folder::new(&[("open.txt", stray.as_str()), ("close.txt", one.as_str())]);
    let errors = folder.read(&both).unwrap_err();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].starts_with("open.txt:31: the lift lies 1.1"), "{errors:?}");
}

#[test]
fn all_errors_of_a_file_are_reported_at_once_with_their_lines() {
    let rows = (0..360).map(|k| format!("{k},{:.3}\n", lift_mm(f64::from(k)))).collect::<String>();
    let text = format!("cam_angle_deg,lift_mm\n{rows}");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[11] = "10,x".into();
    lines[21] = "20".into();
    lines[31] = "30,9.000".into();
    lines[41] = lines[40].clone();
    lines.remove(61);
    lines[300] = "300,NaN".into();
    let errors = read_one(&lines.join("\n"), "{table: t.txt}").unwrap_err();
    let heads: Vec<&str> = errors.iter().map(|error| error.split([',', ';']).next().unwrap_or("")).collect();
    assert_eq!(
        heads,
        [
            "t.txt:12: \"x\" is not a number",
            "t.txt:22: 1 columns",
            "t.txt:32: the lift lies 8.598500 mm off the trend of the rows around it",
            "t.txt:42: angle 39.0000 deg stands already in line 41",
            "t.txt:43: 1 block(s) missing",
            "t.txt:62: 1 block(s) missing",
            "t.txt:301: the lift is NaN",
        ],
        "{errors:#?}"
    );
}

/// Ramps that a blend takes up, a harmonic pair, and every law by its name.
#[test]
fn segments_are_a_lift_and_refusals_point_at_them() {
    let folder = Folder::new(&[]);
    let lift = folder
        .read(
            "{start_deg: 90, segments: [{law: dwell, angle_deg: 60}, {law: modified_sine, angle_deg: 100, rise_mm: 6}, \
               {law: dwell, angle_deg: 20}, {law: 4-5-6-7, angle_deg: 180, rise_mm: -6}]}",
        )
        .unwrap();
    assert!((lift.law.max_lift_mm() - 6.0).abs() < 1e-12 && lift.table.is_none());
    assert!((lift.law.sample(rad_from_deg(260.0)).value - 6.0).abs() < 1e-12);
    let errors = folder.read(
        "{segments: [{law: dwell, angle_deg: 200}, {law: harmonic, angle_deg: 80, rise_mm: 6}, \
         {law: harmonic, angle_deg: 80, rise_mm: -6}]}",
    );
    let text = errors.unwrap_err().join("\n");
    assert!(text.contains("segment 1 (dwell)") && text.contains("the jerk of the X axis would be unbounded"), "{text}");
    let errors = folder.read("{segments: [{law: parabolic, angle_deg: 360}]}").unwrap_err();
    assert!(
        errors[0].contains("segments.0.law is \"parabolic\"; it must be one of dwell, constant_velocity"),
        "{errors:?}"
    );
}

#[test]
fn smoothing_and_the_cubic_spline_are_for_who_asks() {
    let rows = format!("cam_angle_deg,lift_mm\n{}", turn(|angle, lift| format!("{angle:.1},{lift:.3}")));
    let name = |lift: &ProfileLift| lift.law.reading().map(|reading| reading.reading.name());
    let plain = read_one(&rows, "{table: t.txt}").unwrap();
    assert_eq!((name(&plain), plain.others.len()), (Some("smoothest"), 1));
    let cubic = read_one(&rows, "{table: t.txt, reading: cubic_spline}").unwrap();
    assert_eq!((name(&cubic), cubic.others[0].reading.name()), (Some("cubic_spline"), "smoothest"));
    let smooth = read_one(&rows, "{table: t.txt, smooth_within_um: 20}").unwrap();
    let reading = smooth.law.reading().unwrap();
    assert_eq!((name(&smooth), smooth.others.len()), (Some("smooth_within"), 2));
    assert!(reading.max_deviation_mm > 1e-3 && reading.max_deviation_mm <= 0.02 * (1.0 + 1e-9), "{reading:?}");
    assert!(reading.peak_jerk_mm_rad3 <= smooth.others[0].peak_jerk_mm_rad3);
    let errors = read_one(&rows, "{table: t.txt, smooth_within_um: 0.2}").unwrap_err();
    assert!(errors[0].starts_with("job.yaml:1: profile p: smoothing within 0.0002 mm asks for less"), "{errors:?}");
}

#[test]
fn keys_that_contradict_each_other_are_refused() {
    let rows = format!("cam_angle_deg,lift_mm\n{}", turn(|angle, lift| format!("{angle:.1},{lift:.3}")));
    for (lift, words) in [
        ("{}", "exactly one of: table, half_table"),
        ("{table: t.txt, half_table: t.txt}", "exactly one of"),
        ("{eccentric: {eccentricity_mm: 2}, reading: smoothest}", "reading is about a table"),
        ("{table: t.txt, start_deg: 5}", "start_deg is about segments"),
        ("{half_table: t.txt, lowest_lift_mm: -1}", "lowest_lift_mm is about a whole table"),
        ("{eccentric: {eccentricity_mm: 2}, lowest_lift_mm: -1}", "lowest_lift_mm is about segments and whole tables"),
        ("{table: t.txt, lowest_lift_mm: 1}", "lift.lowest_lift_mm is 1; it must be -10000 to 0"),
        ("{table: t.txt, reading: cubic_spline, smooth_within_um: 5}", "passes through every point"),
        ("{table: t.txt, step_cam_deg: 5, step_crank_deg: 5}", "cam and in crank degrees"),
        ("{table: t.txt, step_crank_deg: 5, angle: cam}", "cam and in crank degrees"),
        ("{table: t.txt, smooth_within_um: -1}", "lift.smooth_within_um is -1; it must be 0.000001 to 10000"),
        ("{table: t.txt, colums: [lift_mm]}", "colums"),
        ("{table: t.txt, columns: [cam_angle_deg, lift_mm, lift_inch]}", "two columns of lifts"),
        ("{table: t.txt, columns: [cam_angle_deg, lift_furlong]}", "unknown column \"lift_furlong\""),
    ] {
        let errors = read_one(&rows, lift).unwrap_err();
        assert!(errors[0].contains(words), "{lift}: {errors:?}");
    }
}

#[test]
fn a_table_that_lifts_nothing_is_a_warning_and_a_wrong_column_is_blamed_on_its_key() {
    let zero = turn(|cam, _| format!("{cam},0.000"));
    let lift = read_one(&zero, "{table: t.txt, columns: [cam_angle_deg, lift_mm]}").expect("a round cam");
    assert!(lift.warnings.iter().any(|warning| warning.message.contains("round: true")), "{:?}", lift.warnings);
    let table = turn(|cam, lift| format!("{cam},{lift:.3}"));
    let refused = read_one(&table, "{table: t.txt, columns: [cam_angle_deg, lift_inches]}").unwrap_err();
    assert!(refused[0].contains("job.yaml") && refused[0].contains("unknown column \"lift_inches\""), "{refused:?}");
}

/// `camwright check` of a bare table takes the keys of `lift` with `--set`.
#[test]
fn a_table_alone_is_read_by_its_header_or_by_what_is_set() {
    let inch = turn(|angle, lift| format!("{angle:.1} {:.4}", lift / 25.4));
    let located = Located::new("no-such-folder/t.txt", inch.clone());
    assert!(read_alone(&located, &[]).is_err(), "the file is found by its path");
    let folder = Folder::new(&[("t.txt", inch.as_str())]);
    let located = Located::new(folder.0.path().join("t.txt"), inch);
    let errors = read_alone(&located, &[]).unwrap_err();
    assert!(errors[0].to_string().contains("no header line names the columns"), "{errors:?}");
    let set = ["columns=[cam_angle_deg, lift_inch]".to_owned()];
    is_the_turn(&read_alone(&located, &set).unwrap(), 25.4e-4);
}

/// Texts of anything: a lift or findings that name the file, never a panic.
#[test]
fn no_text_makes_the_reader_panic() {
    let rows = format!("cam_angle_deg;lift_mm\n{}", turn(|angle, lift| format!("{angle:.1};{lift:.3}")));
    let pieces = [
        ";", "\t", ",", ".", "-", "e9", "1e308", "nan", "inf", "#", "\n", "\r\n", "%", "é", "\u{feff}", "lift_mm", "0",
    ];
    let mut state = 20_260_003_u64;
    eprintln!("seed {state}");
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).expect("31 bits") % below
    };
    let lifts = [
        "{table: t.txt}",
        "{table: t.txt, decimal_comma: true}",
        "{half_table: t.txt}",
        "{table: t.txt, columns: [lift_um], step_cam_deg: 5}",
        "{half_table: t.txt, columns: [\"-\", lift_inch], step_crank_deg: 1e-9, header_lines: 3}",
        "{table: t.txt, columns: [increment_mm], header_lines: 9000000}",
    ];
    let folder = Folder::new(&[]);
    for case in 0..1500 {
        let mut text: Vec<char> = rows.chars().collect();
        for _ in 0..1 + next(4) {
            let at = next(text.len());
            let end = (at + next(3) * next(40)).min(text.len());
            text.splice(at..end, pieces[next(pieces.len())].chars());
        }
        std::fs::write(folder.0.path().join("t.txt"), text.iter().collect::<String>()).expect("a file");
        let lift = lifts[next(lifts.len())];
        if let Err(errors) = folder.read(lift) {
            assert!(!errors.is_empty(), "case {case}");
            assert!(errors.iter().all(|error| error.contains("t.txt") || error.contains("job.yaml")), "{errors:?}");
        }
    }
}

/// The lift of an arm may be printed as its angle; it becomes the arc of the arm, as a rise in degrees does.
#[test]
fn degrees_of_an_arm_become_its_arc() {
    let arm_mm = 42.0;
    let pivot = Pivot { distance_mm: 50.0, side: ArmSide::Ahead, lift: SwingLift::Arc { radius_mm: arm_mm } };
    let on_arm = Follower::OscillatingRoller { radius_mm: 8.5, arm_mm, pivot };
    let mm_per_deg = arm_mm * std::f64::consts::PI / 180.0;
    let degrees = turn(|angle, lift_mm| format!("{angle},{lift_mm:.4}"));
    let text = format!("cam_angle_deg,lift_deg\n{degrees}");
    let folder = Folder::new(&[("t.txt", &text)]);
    let lift = folder.read_for("{table: t.txt}", on_arm).unwrap();
    for angle_deg in [10.0, 120.0, 180.0, 200.0] {
        let found = lift.law.sample(f64::to_radians(angle_deg)).value;
        assert!((found - lift_mm(angle_deg) * mm_per_deg).abs() < 0.6e-4 * mm_per_deg, "{angle_deg}: {found}");
    }
    let errors = folder.read("{table: t.txt}").unwrap_err();
    assert_eq!(errors, ["t.txt:1: column lift_deg holds the angle of an arm, and no follower that swings is given"]);
    let segments =
        "{segments: [{law: cycloidal, angle_deg: 180, rise_deg: 6}, {law: cycloidal, angle_deg: 180, rise_deg: -6}]}";
    let lift = folder.read_for(segments, on_arm).unwrap();
    assert!((lift.law.max_lift_mm() - 6.0 * mm_per_deg).abs() < 1e-12);
    let errors = folder.read(segments).unwrap_err();
    assert!(errors.len() == 2 && errors[0].contains("rise_deg is the angle of an arm"), "{errors:?}");
}

/// The law within `bound_mm` of [`wide_lobe_mm`], whatever division the table has.
fn is_the_lobe(lift: &ProfileLift, bound_mm: f64) {
    for k in 0..360 {
        let angle_deg = f64::from(k);
        let off = lift.law.sample(angle_deg.to_radians()).value - wide_lobe_mm(angle_deg);
        assert!(off.abs() <= bound_mm, "{angle_deg} deg: {off} mm");
    }
    assert_eq!(lift.warnings, []);
}

/// A smooth lobe without corners between its rows: 5 mm high over ±90° about 180°.
fn wide_lobe_mm(angle_deg: f64) -> f64 {
    let x = (angle_deg - 180.0) / 90.0;
    if x.abs() < 1.0 { 5.0 * (1.0 - x * x).powi(5) } else { 0.0 }
}

/// Angles of 0 to 360 that lie up to 0.3 of a degree off even ones; the nose at 180 is one of them, so that the largest lift is printed.
fn uneven_deg() -> Vec<f64> {
    let off = |k: u32| if k.is_multiple_of(180) { 0.0 } else { 0.3 * (2.3 * f64::from(k)).sin() };
    (0..=360).map(|k| ((f64::from(k) + off(k)) * 1e4).round() / 1e4).collect()
}

#[test]
fn a_kas_profile_is_read_by_its_largest_values() {
    // 1000 is one turn; 800 is the largest lift of 5 mm.
    let row = |angle: &f64| format!("{:.6};{:.5};SPLINE\n", angle / 0.36, wide_lobe_mm(*angle) * 160.0);
    let rows: String = uneven_deg().iter().map(row).collect();
    let text = format!("CYCLIC;YES;\nTABLE_BEGIN;;\n{rows}TABLE_END;;\n");
    let lift = "{table: t.txt, preset: kas, scale_mm: 5}";
    is_the_lobe(&read_one(&text, lift).unwrap(), 1e-4);
    assert_eq!(
        read_one(&text, "{table: t.txt, preset: kas}").unwrap_err(),
        ["t.txt:3: column lift_share holds shares of the largest lift; `scale_mm` must say how large that is"]
    );
    let cut = text.replace("TABLE_END;;\n", "");
    assert_eq!(
        read_one(&cut, lift).unwrap_err(),
        [
            "t.txt: no line TABLE_END: `preset: kas` needs the rows between TABLE_BEGIN and TABLE_END; is the file complete?"
        ]
    );
    let line = text.replacen("SPLINE", "LINE", 1);
    assert_eq!(
        read_one(&line, lift).unwrap_err(),
        ["t.txt:3: segment LINE: of a KAS profile only segments SPLINE are read"]
    );
}

#[test]
fn a_cam_table_of_the_isg_kernel_is_read_in_its_unit() {
    let rows: String = (0..720).map(|k| format!("{:.0} # {k}\n", wide_lobe_mm(f64::from(k) * 0.5) * 1e4)).collect();
    let head = "Tablename = lobe # name\nTable-ID = 7\nFunctiontype = 2\nLines = 720\nBegintable # begin\n";
    let text = format!("{head}{rows}EndTable # end\n");
    let lift = read_one(&text, "{table: t.txt, preset: isg}").unwrap();
    let table = lift.table.as_ref().expect("a table");
    assert!((table.blocks(), table.digit_mm()) == (720, 1e-4));
    is_the_lobe(&lift, 1e-4);
    assert_eq!(
        read_one(&text.replace("Lines = 720", "Lines = 721"), "{table: t.txt, preset: isg}").unwrap_err(),
        ["t.txt:4: Lines = 721, but 720 rows follow; is the file complete?"]
    );
    let sections = text.replace("Functiontype = 2", "Functiontype = 5");
    assert_eq!(
        read_one(&sections, "{table: t.txt, preset: isg}").unwrap_err(),
        [
            "t.txt:3: Functiontype = 5: only interpolation points at even angles are read (0, 1 or 2), not sections of motion"
        ]
    );
}

#[test]
fn points_of_a_codesys_cam_are_read_with_and_without_their_derivatives() {
    let row = |angle: &f64, more: &str| format!("{angle:.4}\t{:.6}{more}\n", wide_lobe_mm(*angle));
    for more in ["", "\t0.1\t-0.2"] {
        let rows: String = uneven_deg().iter().map(|angle| row(angle, more)).collect();
        is_the_lobe(&read_one(&rows, "{table: t.txt, preset: codesys}").unwrap(), 1e-4);
    }
}

#[test]
fn the_lift_event_of_an_engine_gets_its_base_circle() {
    // From 180° to 540° of the crank, that is 90° to 270° of the cam.
    let rows: String =
        (0..=360).map(|k| format!("{},{:.4}\n", 180 + k, wide_lobe_mm(90.0 + f64::from(k) * 0.5))).collect();
    let lift = read_one(&rows, "{table: t.txt, preset: engine}").unwrap();
    assert_eq!(lift.table.as_ref().expect("a table").blocks(), 720);
    is_the_lobe(&lift, 1e-4);
    // With its nose at the angle 0, and the base circle where the job puts it.
    let rows: String =
        (0..=360).map(|k| format!("{},{:.4}\n", k - 180, wide_lobe_mm(90.0 + f64::from(k) * 0.5))).collect();
    is_the_lobe(&read_one(&rows, "{table: t.txt, preset: engine, zero_deg: 180}").unwrap(), 1e-4);
    assert_eq!(
        read_one(&rows, "{table: t.txt, preset: engine, event_only: false}").unwrap_err(),
        [
            "t.txt:361: the table covers 361.00 deg where one turn of the cam is 720 deg of the crank: these are cam degrees, \
             declared are crank degrees; declare cam degrees, or `event_only: true` if only the base circle is missing"
        ]
    );
    let cut: String = rows.lines().skip(100).map(|line| format!("{line}\n")).collect();
    let errors = read_one(&cut, "{table: t.txt, preset: engine, zero_deg: 180}").unwrap_err();
    assert!(matches!(&errors[..], [only] if only.starts_with("t.txt:1: the flank ends at a lift of ")), "{errors:?}");
}

/// u;s from 0 to 1, as cam designers hand over normalised laws, and angles in radians.
#[test]
fn a_normalised_table_is_scaled_and_radians_are_read() {
    let rows: String = (0..=720)
        .map(|k| format!("{:.8};{:.7}\n", f64::from(k) / 720.0, wide_lobe_mm(f64::from(k) * 0.5) / 5.0))
        .collect();
    let lift = "{table: t.txt, columns: [turn_share, lift_share], scale_mm: 5}";
    is_the_lobe(&read_one(&rows, lift).unwrap(), 1e-6);
    let zeros = "0;0\n".repeat(20);
    let errors = read_one(&zeros, lift).unwrap_err();
    assert_eq!(errors[0], "t.txt:2: angle 0.0000 deg stands already in line 1", "{errors:?}");
    let errors = read_one(&rows, "{table: t.txt, columns: [turn_share, lift_mm], scale_mm: 5}").unwrap_err();
    assert!(errors[0].ends_with("scale_mm is about a column lift_share; the table has none"), "{errors:?}");
    let rows: String = (0..720)
        .map(|k| format!("{:.8};{:.6}\n", (f64::from(k) * 0.5).to_radians(), wide_lobe_mm(f64::from(k) * 0.5)))
        .collect();
    is_the_lobe(&read_one(&rows, "{table: t.txt, columns: [cam_angle_rad, lift_mm]}").unwrap(), 2e-6);
}

/// Mirrored and turned tables at uneven angles keep their rows exactly, whatever the zero.
#[test]
fn uneven_rows_are_mirrored_and_turned_before_they_are_read() {
    let row = |angle: &f64| format!("{angle:.4};{:.6}\n", wide_lobe_mm(180.0 - (*angle - 77.7 - 180.0)));
    let rows: String = uneven_deg().iter().take(360).map(row).collect();
    let columns = "columns: [cam_angle_deg, lift_mm]";
    // The lobe of the table has its nose at 257.7°; against its direction, and turned by 77.7° + 360°, it is at 180°.
    let lift = format!("{{table: t.txt, {columns}, uneven: true, mirrored: true, zero_deg: 437.7}}");
    is_the_lobe(&read_one(&rows, &lift).unwrap(), 1e-4);
    let errors = read_one(&rows, &format!("{{table: t.txt, {columns}}}")).unwrap_err();
    assert!(errors[0].ends_with("; `uneven: true` reads rows at uneven angles"), "{errors:?}");
    let half = read_one("0;5\n1;4\n2;0\n", "{half_table: t.txt, uneven: true}").unwrap_err();
    assert_eq!(
        half,
        ["job.yaml:1: profile p: uneven is about a whole table; the rows of a half table stand at even angles"]
    );
}
