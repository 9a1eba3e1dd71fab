// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A program that `camwright post` made, through the whole cell: the part that it grinds, and what is refused before anything moves.

use crate::support;

use std::path::Path;
use std::process::{Command, Output};
use support::{Domain, Folder};

/// A short job, with few turns.
const SHORT: [&str; 3] = ["infeed.total_mm=0.072", "stock_mm=0.06", "infeed.spark_out_turns=2"];

/// A short piece of the shipped turned part on a coarser grid.
const TURNED: &str = "turned_cam";
const SHORT_TURNED: [&str; 4] =
    ["turned.to_mm=22", "form_grid.azimuths=180", "finishing.along_z_mm=0.3", "roughing.along_z_mm=0.8"];

fn camwright(domain: &Domain, folder: &Folder, words: &[&str], out: (&str, &Path), set: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(words).arg(out.0).arg(out.1);
    let short = if words[1] == TURNED { &SHORT_TURNED[..] } else { &SHORT[..] };
    for over in short.iter().copied().chain(set.iter().map(String::as_str)) {
        command.args(["--set", over]);
    }
    command.output().expect("camwright runs")
}

#[test]
fn a_posted_program_grinds_the_part_and_another_one_moves_nothing() {
    let (domain, folder) = (Domain::reserve(), Folder::new("program-in-the-cell"));
    let program = |name: &str| format!("program={}", folder.join(name).join("four_lobe_camshaft.ngc").display());
    for (name, set) in [("good", vec![]), ("sharp", vec!["nc.path_tolerance_um=0.5".to_owned()])] {
        let out = folder.join(name);
        let posted = camwright(&domain, &folder, &["post", "four_lobe_camshaft"], ("--out", &out), &set);
        assert!(posted.status.success(), "{}", String::from_utf8_lossy(&posted.stderr));
    }
    let run = ["run", "four_lobe_camshaft", "--json"];
    let ground = camwright(&domain, &folder, &run, ("--bag", &folder.join("bag")), &[program("good")]);
    assert!(ground.status.success(), "{}", String::from_utf8_lossy(&ground.stderr));
    let report: serde_json::Value = serde_json::from_slice(&ground.stdout).expect("a report in JSON");
    let lobes = report["lobes"].as_array().expect("lobes");
    assert_eq!(lobes.len(), 4);
    for lobe in lobes {
        let form_um = lobe["form_error_max_um"].as_f64().expect("a number").abs();
        assert!(form_um > 0.1 && form_um < 5.0, "{lobe}");
    }
    // Corners that the axes cannot take within what the program says: refused with the line of the program.
    let refused = camwright(&domain, &folder, &run, ("--bag", &folder.join("bag-sharp")), &[program("sharp")]);
    let stderr = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("four_lobe_camshaft.ngc, line ") && stderr.contains("are allowed"), "{stderr}");
}

/// The simulated lathe turns the part by its program: its form is that of the job's own plan, within the tolerance and the rounding of the
/// corners, and the run replays to the bit from its bag.
#[test]
fn a_posted_program_turns_the_part_that_the_plan_turns() {
    let (domain, folder) = (Domain::reserve(), Folder::new("turned-program-in-the-cell"));
    let out = folder.join("nc");
    let posted = camwright(&domain, &folder, &["post", TURNED], ("--out", &out), &[]);
    assert!(posted.status.success(), "{}", String::from_utf8_lossy(&posted.stderr));
    let run = |name: &str, set: &[String]| -> serde_json::Value {
        let done =
            camwright(&domain, &folder, &["run", TURNED, "--json", "--causes"], ("--bag", &folder.join(name)), set);
        assert!(done.status.success(), "{name}: {}", String::from_utf8_lossy(&done.stderr));
        serde_json::from_slice(&done.stdout).expect("a report in JSON")
    };
    let program = format!("program={}", out.join("turned_cam.ngc").display());
    let (own, programmed) = (run("own", &[]), run("programmed", &[program]));
    let um = |report: &serde_json::Value, key: &str| report["turned"][key].as_f64().expect("a number").abs();
    // C turns more slowly, so the drives lag less.
    let (own_um, programmed_um) = (um(&own, "form_error_max_um"), um(&programmed, "form_error_max_um"));
    assert!(programmed_um > 0.5 && programmed_um < own_um, "{programmed_um} {own_um}");
    // Without them a tolerance of 0.5 um and corners rounded within 2 um are left beside the cusps.
    let ideal = |report: &serde_json::Value, key: &str| {
        report["form_error_instead"]["without servo"][key].as_f64().expect("a number")
    };
    for key in ["highest_um", "lowest_um"] {
        let (own_um, programmed_um) = (ideal(&own, key), ideal(&programmed, key));
        assert!((own_um - programmed_um).abs() < 2.6, "{key}: {programmed_um} {own_um}");
    }
    assert_ne!(own["plan_hash"], programmed["plan_hash"]);
    let verdict = camwright_analysis::rerun::rerun(&folder.join("programmed")).expect("the bag holds what it takes");
    assert!(verdict.is_identical() && verdict.setpoints > 1000, "{}", verdict.to_text());
    // A program for a spindle that turns the other way would make the mirror image.
    let other = ["nc.rotation_sense=-1".to_owned(), format!("program={}", out.join("turned_cam.ngc").display())];
    let refused = camwright(&domain, &folder, &["run", TURNED, "--json"], ("--bag", &folder.join("bag-other")), &other);
    let stderr = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(1) && stderr.contains("rotation sense of -1"), "{stderr}");
}
