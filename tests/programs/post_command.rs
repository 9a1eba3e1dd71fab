// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright post`: programs of the shipped jobs for every control, read back, and what makes no program.

use crate::support;

use std::path::Path;
use std::process::{Command, Output};
use support::Folder;

fn post(job: &str, out: &Path, set: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(["post", job, "--json", "--out"]).arg(out);
    for over in set {
        command.arg("--set").arg(over);
    }
    command.output().expect("camwright runs")
}

fn posted(job: &str, out: &Path, set: &[&str]) -> serde_json::Value {
    let output = post(job, out, set);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{job} {set:?}: {errors}");
    serde_json::from_slice(&output.stdout).expect("a summary in JSON")
}

fn refusal(job: &str, set: &[&str]) -> String {
    let folder = Folder::new("post-refused");
    let output = post(job, folder.path(), set);
    assert_eq!(output.status.code(), Some(2), "{job} {set:?}");
    let written = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(written, 0, "{job} {set:?}: nothing is left behind");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    errors.lines().find(|line| line.starts_with("error: ")).expect("an error").to_owned()
}

#[test]
fn shipped_jobs_give_programs_for_every_control_that_come_back_within_their_tolerances() {
    let diameter = vec!["nc.x_values=diameter", "nc.x_of=cutting_edge"];
    for (job, set) in [
        ("four_lobe_camshaft", vec![]),
        ("rough_and_finish", vec!["nc.rotation_sense=-1"]),
        ("eccentric", diameter),
        ("plate_groove", vec![]),
        ("barrel_groove", vec!["grooves.B.name=groove_of_the_indexer"]),
        ("level_wind", vec![]),
        ("barrel_indexer", vec!["nc.rotation_sense=-1"]),
    ] {
        for (control, files) in [("linuxcnc", "ngc"), ("fanuc", "NC"), ("siemens", "SPF")] {
            let folder = Folder::new("post");
            let control_is = format!("nc.control={control}");
            let set: Vec<&str> = set.iter().copied().chain([control_is.as_str()]).collect();
            let summary = posted(job, folder.path(), &set);
            let back = &summary["read_back"];
            let share = back["share_of_tolerance"].as_f64().expect("a number");
            assert!(share > 0.5 && share <= 1.0, "{job} {set:?}: {share}");
            let turns = summary["turns"].as_array().expect("turns");
            let longest_s = turns.iter().filter_map(|turn| turn["time_s"].as_f64()).fold(0.0, f64::max);
            // A Fanuc's F has three places: F 0.75 of a block of 80 s is wrong by up to 0.05 s.
            let share_s = if control == "fanuc" { 2e-4 } else { 5e-5 };
            assert!(back["time_error_s"].as_f64().expect("a number") < share_s * longest_s, "{job} {set:?}: {back}");
            let names = summary["files"].as_array().expect("files");
            assert!(names.iter().all(|name| folder.join(name.as_str().expect("a name")).is_file()));
            assert!(names.iter().any(|name| name.as_str().expect("a name").ends_with(files)), "{names:?}");
            for turn in turns {
                let number = |key: &str| turn[key].as_f64().expect("a number");
                assert!(number("error_um") <= number("tolerance_um"), "{turn}");
                assert!(number("blocks_s") <= 500.0, "{turn}");
                // What rounding takes of the tolerance is beside theory.
                assert!(number("segments") < 1.25 * number("theoretical_segments") + 3.0, "{turn}");
            }
        }
    }
}

/// A short piece of the shipped turned part.
const TURNED: [&str; 3] = ["turned.to_mm=21.5", "finishing.along_z_mm=0.4", "roughing.along_z_mm=0.8"];

fn turned<'a>(set: &[&'a str]) -> Vec<&'a str> {
    TURNED.iter().chain(set).copied().collect()
}

#[test]
fn a_turned_part_gives_a_program_that_states_what_it_is() {
    for (set, name) in [
        (vec![], "turned_cam.ngc"),
        (vec!["nc.control=siemens", "nc.x_values=diameter", "nc.x_of=cutting_edge"], "TURNED_CAM.MPF"),
        (vec!["nc.rotation_sense=-1", "nc.knots=free", "spindle.law=varied"], "turned_cam.ngc"),
        // Eight digits: three decimals of C for the turns of a pass; a block takes 6 ms at least.
        (vec!["nc.control=fanuc", "nc.rotary_decimals=3", "spindle.law=constant", "spindle.rpm=25"], "O1000.NC"),
    ] {
        let folder = Folder::new("post-turned");
        let set = turned(&set);
        let summary = posted("turned_cam", folder.path(), &set);
        let back = &summary["read_back"];
        let share = back["share_of_tolerance"].as_f64().expect("a number");
        assert!(share > 0.5 && share <= 1.0, "{set:?}: {share}");
        assert_eq!(summary["calls"], 3, "{set:?}");
        let passes = summary["turns"].as_array().expect("passes");
        let names: Vec<&str> = passes.iter().filter_map(|pass| pass["pass"].as_str()).collect();
        assert_eq!(names, ["roughing 1", "roughing 2", "finishing"], "{set:?}");
        for pass in passes {
            let number = |key: &str| pass[key].as_f64().expect("a number");
            assert!(number("error_um") <= number("tolerance_um") && number("blocks_s") <= 500.0, "{pass}");
        }
        let text = std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let text = text.to_lowercase();
        let hash = summary["job_hash"].as_str().expect("a hash");
        for words in [
            "lengths in mm",
            "angles in degrees",
            "tolerances",
            "round insert",
            "radius 8.000",
            "rake face 14.000 mm below centre",
            "largest error",
            &hash[..16],
        ] {
            assert!(text.contains(words), "{set:?}: {words}\n{text:.1200}");
        }
        let segments = std::fs::read_to_string(folder.join("turned_cam").join("finishing_segments.csv"));
        let segments = segments.expect("segments");
        assert!(segments.starts_with("c_deg,x_mm,z_mm,x_slope_mm_deg,z_slope_mm_deg\n"), "{segments:.100}");
        assert_eq!(segments.lines().count() as u64, passes[2]["blocks"].as_u64().expect("a count") + 2, "{set:?}");
    }
}

fn params(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params").join(file);
    std::fs::read_to_string(path).expect("a file of params/")
}

/// A lathe whose insert turns the other way, and one whose insert is clamped: M4, and no spindle at all.
#[test]
fn the_insert_rotates_as_its_machine_says_or_not_at_all() {
    let folder = Folder::new("post-turned-insert");
    let lathe = params("machines/lathe.yaml");
    let spindle = "  surface_speed_m_s: 2.0\n  spin_up_s: 1.0\n  max_speed_rpm: 6000.0\n";
    assert!(lathe.contains(spindle), "{lathe}");
    let job = params("jobs/turned_cam.yaml");
    let job = folder.write("turned_cam.yaml", &job.replace("machine: lathe", "machine: own_lathe.yaml"));
    let job = job.display().to_string();
    for (own, code) in [
        (spindle.to_owned() + "  rotation: clockwise\n", Some("M3")),
        (spindle.to_owned() + "  rotation: counterclockwise\n", Some("M4")),
        ("  rotates: false\n".to_owned(), None),
    ] {
        folder.write("own_lathe.yaml", &lathe.replace(spindle, &own));
        for (control, name) in [("linuxcnc", "turned_cam.ngc"), ("siemens", "TURNED_CAM.MPF"), ("fanuc", "O1000.NC")] {
            let control = format!("nc.control={control}");
            let set = turned(&[&control, "nc.rotary_decimals=3", "spindle.law=constant", "spindle.rpm=25"]);
            posted(&job, folder.path(), &set);
            let text = std::fs::read_to_string(folder.join(name)).expect("a program");
            let found: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("S2387 ")).collect();
            assert_eq!(found, Vec::from_iter(code), "{control}");
            assert_eq!(text.lines().any(|line| line == "M5"), code.is_some(), "{control}");
        }
    }
    let found = refusal(&job, &turned(&["nc.spindle_rpm=900"]));
    assert!(found.contains("nc.spindle_rpm is for an insert that rotates"), "{found}");
}

#[test]
fn what_makes_no_program_of_a_turned_part_is_refused_with_its_key() {
    for (set, words) in [
        (vec!["nc.lead_deg=30"], "nc.lead_deg does not apply to a turning job"),
        (vec!["nc.finish_tolerance_um=0"], "finish_tolerance_um is 0; it must be 0.01 to 1000"),
        (vec!["nc.finish_tolerance_um=0.05"], "finishing: a tolerance of 0.05 um leaves nothing beside"),
        (vec!["nc.most_blocks_s=20", "spindle.law=constant", "spindle.rpm=50"], "the control reads 20. It would at "),
        (
            vec!["nc.control=fanuc", "turned.to_mm=10", "spindle.law=constant", "spindle.rpm=20"],
            "fewer decimals of angles",
        ),
        (vec!["machine=cam_grinder"], "the machine grinds with a wheel; turning needs a lathe"),
        (
            vec!["spindle.law=constant", "spindle.rpm=340", "nc.most_blocks_s=5000", "nc.path_tolerance_um=0.5"],
            "rpm, or more with a larger",
        ),
    ] {
        let found = refusal("turned_cam", &turned(&set));
        assert!(found.contains(words) && found.contains(".yaml"), "{set:?}: {found}");
    }
    let found = refusal("turned_cam", &turned(&["program=nothing.ngc"]));
    assert!(found.contains("nothing.ngc: not found"), "{found}");
}

/// Three figures to a program and its pictures, and the same contour as the closed form's: X(θ) = E cos θ + √((D/2 + R)² − E² sin² θ).
#[test]
fn three_figures_give_a_program_and_pictures_of_an_eccentric() {
    let folder = Folder::new("post-eccentric");
    let figures = ["--eccentric", "4.2", "--diameter", "38", "--tool-radius", "15", "--out"];
    let output = Command::new(env!("CARGO_BIN_EXE_camwright")).arg("post").args(figures).arg(folder.path()).output();
    let output = output.expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["eccentric_disc.ngc", "A/tool_path.png", "A/tool_path.svg", "A/finish_segments.png"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let text = std::fs::read_to_string(folder.join("A/finish_segments.csv")).expect("segments");
    let mut knots = 0;
    for row in text.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').take(2).map(|cell| cell.parse().expect("a number")).collect();
        let [c_deg, x_mm] = cells[..] else { panic!("{row}") };
        if (0.0..=360.0).contains(&c_deg) {
            let (sin, cos) = c_deg.to_radians().sin_cos();
            let exact = 4.2 * cos + (34.0_f64.powi(2) - (4.2 * sin).powi(2)).sqrt();
            assert!((x_mm - exact).abs() <= 0.0005, "{c_deg} deg: {x_mm} {exact}");
            knots += 1;
        }
    }
    assert!(knots > 100, "{knots}");
}

#[test]
fn the_same_job_gives_the_same_bytes_with_what_it_was_made_of_and_no_date() {
    let (one, other) = (Folder::new("post-one"), Folder::new("post-other"));
    let first = posted("eccentric", one.path(), &[]);
    posted("eccentric", other.path(), &[]);
    for name in
        ["eccentric.ngc", "summary.json", "A/tool_path.svg", "A/tool_path.png", "A/grind_spark-out_segments.csv"]
    {
        let bytes =
            |folder: &Folder| std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(bytes(&one) == bytes(&other), "{name}");
    }
    let text = std::fs::read_to_string(one.join("eccentric.ngc")).expect("a program");
    let hash = first["job_hash"].as_str().expect("a hash");
    assert!(
        text.contains(&hash[..16]) && text.contains("tolerances- grind infeed 10 um; grind spark-out 0.5 um"),
        "{text:.600}"
    );
}

#[test]
fn what_makes_no_program_is_refused_with_its_key() {
    let eccentric = |set: &[&str]| refusal("eccentric", set);
    for (words, found) in [
        ("finish_tolerance_um is 0; it must be 0.01 to 1000", eccentric(&["nc.finish_tolerance_um=0"])),
        ("rough_tolerance_um is 1000000; it must be", eccentric(&["nc.rough_tolerance_um=1e6"])),
        ("most_blocks_s is -1", eccentric(&["nc.most_blocks_s=-1"])),
        ("rotation_sense is 0; it must be 1 or -1", eccentric(&["nc.rotation_sense=0"])),
        ("nc.linear_decimals is 9; it must be 1 to 6", eccentric(&["nc.linear_decimals=9"])),
        ("nc.rotary_decimals is 0; it must be 1 to 6", eccentric(&["nc.rotary_decimals=0"])),
        ("leaves nothing beside", eccentric(&["nc.linear_decimals=2", "nc.finish_tolerance_um=1"])),
        ("nc.control is \"abacus\"; it must be one of linuxcnc, fanuc, siemens", eccentric(&["nc.control=abacus"])),
        ("nc.dialect is an unknown key", eccentric(&["nc.dialect=fanuc"])),
        (
            "the control reads 20. It would at ",
            eccentric(&["nc.most_blocks_s=20", "nc.widest_tolerance_um=1", "work_speed_rpm=200"]),
        ),
        ("an NC program cannot do this; remove it (--set runout_correction=null)", refusal("journal_runout", &[])),
        ("dresses the wheel", refusal("dressed_batch", &[])),
        ("is a dry run", eccentric(&["dry_run.stand_off_mm=5"])),
    ] {
        assert!(found.contains(words), "{found}");
        assert!(found.contains(".yaml"), "{found}");
    }
}
