//! What cannot be made is refused with one clear sentence that names file, line, value and bound.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder of its own per test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("refusals-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder under target/tmp");
        Self(path)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).expect("a file under target/tmp");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _gone_already = std::fs::remove_dir_all(&self.0);
    }
}

fn params(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../params").join(file);
    std::fs::read_to_string(path).expect("a file of params/")
}

/// Exit code and standard error of `camwright check`.
fn check(path: &Path) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_camwright")).arg("check").arg(path).output().expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap_or(-1), text)
}

/// A copy of the default job with changes to its text and to its intake table.
fn refused(
    name: &str,
    change: impl Fn(String) -> String,
    table: impl Fn(Vec<String>) -> Vec<String>,
    expected: &[&str],
) {
    let folder = Folder::new(name);
    let rows = table(params("lifts/intake.csv").lines().map(str::to_owned).collect());
    folder.write("intake.csv", &(rows.join("\n") + "\n"));
    folder.write("exhaust.csv", &params("lifts/exhaust.csv"));
    let job = folder.write("job.yaml", &change(params("jobs/four_lobe_camshaft.yaml")));
    let (code, text) = check(&job);
    assert_eq!(code, 2, "{name} must be refused: {text}");
    for part in expected {
        assert!(text.contains(part), "{name}: {part:?} is not in: {text}");
    }
}

fn same<T>(value: T) -> T {
    value
}

#[test]
fn a_duplicate_angle() {
    let duplicate = |mut rows: Vec<String>| {
        rows[1203] = rows[1202].clone();
        rows
    };
    refused("duplicate", same, duplicate, &["intake.csv:1204", "119.9", "1203"]);
}

#[test]
fn a_missing_block() {
    let missing = |mut rows: Vec<String>| {
        rows.remove(1203);
        rows
    };
    refused("missing", same, missing, &["intake.csv:1204", "1 block", "120.0"]);
}

#[test]
fn a_nan() {
    let nan = |mut rows: Vec<String>| {
        rows[1203] = "120.0,NaN".into();
        rows
    };
    refused("nan", same, nan, &["intake.csv:1204", "NaN"]);
}

#[test]
fn crank_degrees_where_cam_degrees_are_declared() {
    let crank = |rows: Vec<String>| {
        let double = |row: String| match row.split_once(',') {
            Some((angle, lift)) if !row.starts_with(['#', 'c']) => {
                format!("{:.1},{lift}", 2.0 * angle.parse::<f64>().expect("an angle"))
            }
            _ => row,
        };
        rows.into_iter().map(double).collect()
    };
    refused("crank", same, crank, &["intake.csv", "crank degrees", "360"]);
}

#[test]
fn a_step() {
    let step = |rows: Vec<String>| {
        let raise = |(index, row): (usize, String)| match row.split_once(',') {
            Some((angle, lift)) if (1503..2103).contains(&index) => {
                format!("{angle},{:.3}", lift.parse::<f64>().expect("a lift") + 0.2)
            }
            _ => row,
        };
        rows.into_iter().enumerate().map(raise).collect()
    };
    refused("step", same, step, &["intake.csv:1504", "jumps"]);
}

#[test]
fn an_undercut_lobe() {
    let undercut = |text: String| {
        text.replacen("radius_mm: 8.5", "radius_mm: 45.0", 1).replacen("base_radius_mm: 16.0", "base_radius_mm: 6.0", 1)
    };
    let steep = |rows: Vec<String>| {
        let triple = |row: String| match row.split_once(',') {
            Some((angle, lift)) if !row.starts_with(['#', 'c']) => {
                format!("{angle},{:.3}", 3.0 * lift.parse::<f64>().expect("a lift"))
            }
            _ => row,
        };
        rows.into_iter().map(triple).collect()
    };
    refused("undercut", undercut, steep, &["job.yaml", "undercut"]);
}

#[test]
fn an_unknown_key() {
    let unknown = |text: String| text.replace("work_speed_rpm:", "work_speed_rmp:");
    refused("unknown-key", unknown, same, &["job.yaml", "work_speed_rmp"]);
}

#[test]
fn two_lobes_on_one_station() {
    let twice = |text: String| text.replace("station: LS2", "station: LS1");
    refused("one-station", twice, same, &["job.yaml:", "I1", "E1", "LS1"]);
}

#[test]
fn a_station_without_a_switch() {
    let without = |text: String| text.replace("station: LS4", "station: LS9");
    refused("no-switch", without, same, &["job.yaml:", "E2", "LS9", "LS1, LS2, LS3, LS4"]);
}

#[test]
fn a_newer_schema() {
    let newer = |text: String| text.replace("camwright/job/1", "camwright/job/9");
    refused("schema", newer, same, &["job.yaml:3", "version 9", "up to version 1"]);
}

#[test]
fn a_total_infeed_that_is_no_whole_number_of_turns() {
    let off = |text: String| text.replace("total_mm: 0.36 ", "total_mm: 0.35 ");
    refused("infeed", off, same, &["job.yaml:", "0.35", "0.324", "0.36"]);
}

#[test]
fn the_default_job_is_clean() {
    let (code, text) = check(Path::new("four_lobe_camshaft"));
    assert_eq!(code, 0, "{text}");
}
