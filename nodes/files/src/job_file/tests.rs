use super::*;

fn findings(change: impl Fn(&str) -> String) -> Vec<String> {
    let located = locate("jobs", "eccentric", "yaml", None).unwrap();
    let located = Located::new("job.yaml", change(&located.text));
    read(&located, &[]).err().unwrap_or_default().iter().map(ToString::to_string).collect()
}

#[test]
fn every_value_out_of_range_is_reported_with_its_line() {
    let found = findings(|text| {
        text.replace("stock_mm: 0.3", "stock_mm: -0.3").replace("spark_out_turns: 3", "spark_out_turns: 0")
    });
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("stock_mm is -0.3; it must be 0.000001 to 10000"), "{found:?}");
    assert!(
        found[1].starts_with("job.yaml:1") && found[1].contains("spark_out_turns is 0; it must be 1 to 1000"),
        "{found:?}"
    );
}

/// The four lobes with an exhaust table of half as many blocks, and something more in the job.
fn of_two_divisions(more: &str) -> Result<Job, Vec<String>> {
    let folder = std::env::temp_dir().join(format!("camwright-divisions-{}-{}", std::process::id(), more.len()));
    std::fs::create_dir_all(&folder).unwrap();
    let written =
        |kind: &str, name: &str| locate(kind, name, if kind == "jobs" { "yaml" } else { "csv" }, None).unwrap();
    let exhaust = written("lifts", "exhaust").text;
    let is_row = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
    let head = exhaust.lines().filter(|line| !is_row(line));
    let rows: Vec<&str> = head.chain(exhaust.lines().filter(is_row).step_by(2)).collect();
    std::fs::write(folder.join("exhaust.csv"), rows.join("\n")).unwrap();
    std::fs::write(folder.join("intake.csv"), written("lifts", "intake").text).unwrap();
    let text = written("jobs", "four_lobe_camshaft").text + more;
    let read = read(&Located::new(folder.join("job.yaml"), text), &[]);
    std::fs::remove_dir_all(folder).unwrap();
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
