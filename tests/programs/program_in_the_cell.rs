//! A program that `camwright post` made, through the whole cell: the part that it grinds, and what is refused before anything moves.

use crate::support;

use std::path::Path;
use std::process::{Command, Output};
use support::{Domain, Folder};

/// A short job, with few turns.
const SHORT: [&str; 3] = ["infeed.total_mm=0.072", "stock_mm=0.06", "infeed.spark_out_turns=2"];

fn camwright(domain: &Domain, folder: &Folder, words: &[&str], out: (&str, &Path), set: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(words).arg(out.0).arg(out.1);
    for over in SHORT.iter().copied().chain(set.iter().map(String::as_str)) {
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
