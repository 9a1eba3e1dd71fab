// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;

fn findings(change: impl Fn(&str) -> String) -> Vec<String> {
    let located = locate("jobs", "eccentric", "yaml", None).unwrap();
    let located = Located::new("job.yaml", change(&located.text));
    read(&located, &[]).err().unwrap_or_default().iter().map(ToString::to_string).collect()
}

#[test]
fn every_value_out_of_range_is_reported_with_its_line() {
    let found = findings(|text| {
        text.replace("stock_mm: 0.3", "stock_mm: -0.3").replace("spark_out_turns: 3", "spark_out_turns: -1")
    });
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("stock_mm is -0.3; it must be 0.000001 to 10000"), "{found:?}");
    assert!(
        found[1].starts_with("job.yaml:1") && found[1].contains("spark_out_turns is -1; it must be 0 to 1000"),
        "{found:?}"
    );
}

/// The four lobes with an exhaust table of half as many blocks, and something more in the job.
fn of_two_divisions(more: &str) -> Result<Job, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let written =
        |kind: &str, name: &str| locate(kind, name, if kind == "jobs" { "yaml" } else { "csv" }, None).unwrap();
    let exhaust = written("lifts", "exhaust").text;
    let is_row = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
    let head = exhaust.lines().filter(|line| !is_row(line));
    let rows: Vec<&str> = head.chain(exhaust.lines().filter(is_row).step_by(2)).collect();
    std::fs::write(folder.path().join("exhaust.csv"), rows.join("\n")).unwrap();
    std::fs::write(folder.path().join("intake.csv"), written("lifts", "intake").text).unwrap();
    let text = written("jobs", "four_lobe_camshaft").text + more;
    let read = read(&Located::new(folder.path().join("job.yaml"), text), &[]);
    read.map_err(|findings| findings.iter().map(ToString::to_string).collect())
}

#[test]
fn tables_of_different_division_need_the_blocks_of_the_infeed() {
    let found = of_two_divisions("").err().unwrap();
    assert_eq!(found.len(), 1, "{found:?}");
    let expected =
        "profile exhaust: 1800 blocks per turn, the first table has 3600; if tables differ, set blocks_per_turn";
    assert!(found[0].contains("job.yaml:") && found[0].contains(expected), "{found:?}");

    let job = of_two_divisions("blocks_per_turn: 3600\n").unwrap();
    assert_eq!(job.spec.blocks_per_turn, 3600);
    let blocks = |profile: usize| job.lifts[profile].table.as_ref().unwrap().blocks();
    assert_eq!((blocks(0), blocks(1)), (3600, 1800));
    assert_eq!(of_two_divisions("blocks_per_turn: 1800\n").unwrap().spec.blocks_per_turn, 1800);

    let found = of_two_divisions("blocks_per_turn: 5\n").err().unwrap();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("blocks_per_turn is 5; it must be 36 to 36000"), "{found:?}");
}

/// 36 µm per turn are 3600 blocks of 0.01 µm.
#[test]
fn the_infeed_is_set_per_block_or_per_turn() {
    let per_block = "per_block_um: 0.01";
    let passes = |with: &str| {
        let located = locate("jobs", "eccentric", "yaml", None).unwrap();
        read(&Located::new("job.yaml", located.text.replace(per_block, with)), &[]).map(|job| job.spec.passes)
    };
    assert_eq!(passes("per_turn_um: 36"), passes(per_block));
    let found = findings(|text| text.replace(per_block, "per_block_um: 0.01, per_turn_um: 36"));
    assert!(found.len() == 1 && found[0].contains("infeed has both per_turn_um and per_block_um"), "{found:?}");
    let found = findings(|text| text.replace(per_block, "along: normal"));
    assert!(found.len() == 1 && found[0].contains(":19: infeed needs per_turn_um, the infeed per turn"), "{found:?}");
    let set = ["infeed.per_block_um=null", "infeed.per_turn_um=36"].map(str::to_owned);
    assert_eq!(Ok(load("eccentric", &set).unwrap().spec.passes), passes(per_block));
}

/// A list has one value per turn; ranges hold for each of its values.
#[test]
fn the_infeed_per_turn_may_be_a_list() {
    let with = |list: &str| {
        let set = ["infeed.per_block_um=null".to_owned(), format!("infeed.per_turn_um={list}")];
        load("eccentric", &set).map(|job| job.spec.passes[0].clone()).map_err(|error| error.to_string())
    };
    let pass = with("[100, 80.5, 36]").unwrap();
    assert_eq!(pass.infeed_of_turns_mm, [0.1, 0.0805, 0.036]);
    assert!((pass.infeed_per_block_mm - 0.2165 / 3.0 / 3600.0).abs() < 1e-15, "{pass:?}");
    assert!(with("36").unwrap().infeed_of_turns_mm.is_empty());
    for (list, words) in [
        ("[]", "infeed.per_turn_um has 0 entries; it must have 1 to 1000"),
        ("[36, 0]", "infeed.per_turn_um.1 is 0; it must be 0.000001 to 100000"),
        ("[36, -1, 2]", "infeed.per_turn_um.1 is -1; it must be 0.000001 to 100000"),
        ("[36, deep]", "infeed.per_turn_um.1 is the text \"deep\"; it must be a number"),
        ("deep", "infeed.per_turn_um is the text \"deep\"; it must be a number or a list"),
        ("2e5", "infeed.per_turn_um is 200000; it must be 0.000001 to 100000"),
    ] {
        let error = with(list).expect_err(list);
        assert!(error.contains(words), "{list}: {error}");
    }
    let found = findings(|text| text.replace("per_block_um: 0.01", "per_block_um: 0.01, per_turn_um: [36, 20]"));
    assert!(found.len() == 1 && found[0].contains("infeed has both per_turn_um and per_block_um"), "{found:?}");
}

/// The step of the pulses divides a turn, and a lobe has no more steps than can be written.
#[test]
fn pulses_have_a_step_that_divides_a_turn() {
    let with = |pulses: &str| {
        let set = [format!("pulses={{c_deg: 0.001, x_um: 0.5{pulses}}}")];
        load("eccentric", &set).map(|job| job.pulses.unwrap()).map_err(|error| error.to_string())
    };
    let pulses = with("").unwrap();
    assert_eq!(
        (pulses.c_deg, pulses.x_mm, pulses.steps_per_turn, pulses.max_frequency_hz),
        (0.001, 0.0005, 3600, None)
    );
    assert_eq!(with(", step_deg: 0.5, max_frequency_hz: 2e5").unwrap().steps_per_turn, 720);
    for (more, words) in [
        (", step_deg: 0.7", "pulses.step_deg is 0.7; it must be a whole part of 360 deg, the nearest is 0.70038"),
        (", step_deg: 60", "pulses.step_deg is 60; it must be 0.01 to 45"),
        (", max_frequency_hz: 0", "pulses.max_frequency_hz is 0; it must be 1 to 1000000000"),
    ] {
        let error = with(more).expect_err(more);
        assert!(error.contains(words), "{more}: {error}");
    }
    let many = ["pulses={c_deg: 0.001, x_um: 0.5, step_deg: 0.01}".to_owned(), "infeed.spark_out_turns=100".to_owned()];
    let error = load("eccentric", &many).expect_err("more than 100 turns of 36000 steps").to_string();
    assert!(error.contains("at most 2000000 are counted; set pulses.step_deg to 0.0"), "{error}");
}

/// DS4 to DS7 as printed in JPS6156064B2 have the other sign.
#[test]
fn a_phase_may_have_the_sign_of_the_patent() {
    let with = |key: &str| {
        let located = locate("jobs", "eccentric", "yaml", None).unwrap();
        let text = located.text.replace("phase_deg: 0.0", key);
        read(&Located::new("job.yaml", text), &[]).map(|job| job.spec.lobes[0].phase_rad)
    };
    assert_eq!(with("alpha_deg: 75.5").unwrap().to_bits(), with("phase_deg: -75.5").unwrap().to_bits());
    for (keys, words) in
        [("alpha_deg: 1, phase_deg: -1", "both are given; remove one"), ("width_mm: 14", "one is needed")]
    {
        let found = findings(|text| text.replace("phase_deg: 0.0, width_mm: 14.0", &format!("{keys}, width_mm: 14.0")));
        let is_expected = |error: &String| error.contains(words) || error.contains("width_mm");
        assert!(found.iter().any(is_expected), "{keys}: {found:?}");
    }
}

#[test]
fn a_fault_without_effect_is_reported_with_its_line() {
    let with = |fault: &str| findings(|text| format!("{text}\nfaults:\n  - {fault}\n"));
    assert!(with("{kind: drive_fault, target: x_axis, at_s: 3.5}").is_empty());
    assert!(with("{kind: estop, at_tick: 1}").is_empty());
    for (fault, expected) in [
        ("{kind: gremlin, at_s: 1}", "there is no fault \"gremlin\""),
        ("{kind: drive_fault, target: LS1, at_s: 1}", "drive_fault: target \"LS1\" is not c_axis, x_axis or z_axis"),
        ("{kind: estop}", "a fault needs one of at_tick and at_s"),
        ("{kind: estop, at_tick: 1, at_s: 1}", "a fault needs one of at_tick and at_s"),
        ("{kind: estop, at_tick: 0}", "faults.0.at_tick is 0; it must be at least 1"),
        ("{kind: estop, at_s: -1}", "faults.0.at_s is -1; it must be 0 to 1000000"),
        ("{kind: wheel_overspeed, value: 9, at_s: 1}", "value 9 is outside 1 to 3"),
    ] {
        let found = with(fault);
        assert!(found.len() == 1 && found[0].contains(expected), "{fault}: {found:?}");
    }
}

#[test]
fn a_job_may_begin_with_any_lobe_by_name_or_number() {
    let lobes = |start: &str| {
        let job = load("four_lobe_camshaft", &[format!("start_at={start}")]);
        let job = job.map_err(|error| error.to_string())?;
        Ok((job.spec.lobes.iter().map(|lobe| lobe.name.clone()).collect::<Vec<_>>(), job.starts_in_the_middle))
    };
    for (start, left, middle) in [("E1", 3, true), ("2", 3, true), ("I1", 4, true), ("0", 4, false), ("\"\"", 4, false)]
    {
        let found: Result<_, String> = lobes(start);
        assert_eq!(found.map(|(lobes, middle)| (lobes.len(), middle)), Ok((left, middle)), "{start}");
    }
    for start in ["E9", "5"] {
        let refused = lobes(start).expect_err("no such lobe");
        assert!(
            refused.contains("unknown start lobe ") && refused.contains("; the lobes are I1, E1, I2, E2"),
            "{refused}"
        );
    }
}

#[test]
fn a_lobe_name_is_no_path() {
    let found = findings(|text| text.replace("name: A,", "name: \"../A\","));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("lobes.0.name is \"../A\"; it must be 1 to 64 letters, digits"), "{found:?}");
}

#[test]
fn the_hash_follows_every_override() {
    let hash = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        load("eccentric", &overrides).unwrap().hash
    };
    assert_eq!(hash(&[]), hash(&[]));
    assert_ne!(hash(&[]), hash(&["stock_mm=0.25"]));
}

/// Two cams on one shaft and their joined followers, read off the contours by a gauge: the followers hold the shaft without play at every
/// angle.
#[test]
fn conjugate_cams_hold_their_followers_without_play() {
    use camwright::cam::contour::Contour;
    use camwright::cam::inspection::Inspection;
    use camwright::math::units::TURN_RAD;

    let laws = "{segments: [{law: dwell, angle_deg: 150}, {law: modified_sine, angle_deg: 90, rise_mm: 9}, \
                {law: 4-5-6-7, angle_deg: 120, rise_mm: -9}], start_deg: 20}";
    let profiles = |first: &str, second: &str, lift: &str| {
        let located = locate("jobs", "eccentric", "yaml", None).unwrap();
        let text = located.text.replace(
            "profiles:\n",
            &format!(
                "profiles:\n  - {{name: first, base_radius_mm: 24, follower: {first}, lift: {laws}}}\n  \
             - {{name: second, base_radius_mm: 20, follower: {second}, lift: {lift}}}\n"
            ),
        );
        read(&Located::new("job.yaml", text), &[])
            .map(|job| job.spec.profiles)
            .map_err(|findings| findings.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let readings = |profile: &ProfileSpec| {
        let contour = Contour::from_lift(&profile.lift, &profile.follower, profile.base_radius_mm).unwrap();
        let inspection = Inspection::new(&contour, &profile.follower).unwrap();
        move |angle_rad: f64| inspection.read(angle_rad).unwrap().lift
    };
    let arm = |arm_mm: u32, pivot_mm: u32, side: &str| {
        format!("{{kind: oscillating_roller, radius_mm: 9, arm_mm: {arm_mm}, pivot_mm: {pivot_mm}, side: {side}}}")
    };
    let (roller, arm_first, arm_second) =
        ("{kind: roller, radius_mm: 10}", arm(50, 62, "ahead"), arm(40, 50, "behind"));
    for (first, second, at_rad, ratio) in
        [(roller, "{kind: flat}", TURN_RAD / 2.0, 1.0), (&arm_first, &arm_second, 0.0, 40.0 / 50.0)]
    {
        let profiles = profiles(first, second, "{conjugate_of: first}").unwrap();
        let (of_first, of_second) = (readings(&profiles[0]), readings(&profiles[1]));
        for step in 0..720 {
            let angle_rad = f64::from(step) * TURN_RAD / 720.0;
            let play_mm = of_first(angle_rad) + of_second(angle_rad + at_rad) / ratio - 9.0;
            assert!(play_mm.abs() < 1e-8, "{first}: {play_mm} mm at {step}");
        }
    }
    for (second, lift, words) in [
        (roller, "{conjugate_of: third}", "conjugate_of is third; profiles without errors before this one: first"),
        (&arm_second, "{conjugate_of: first}", "both slide or both swing"),
        (roller, "{round: true, conjugate_at_deg: 0}", "conjugate_at_deg is about conjugate_of; this lift has none"),
        (roller, "{conjugate_of: first, reading: smoothest}", "reading is about a table; this lift is a formula"),
    ] {
        let found = profiles(roller, second, lift).unwrap_err();
        assert!(found.iter().any(|error| error.contains(words)), "{words}: {found:?}");
    }
}
