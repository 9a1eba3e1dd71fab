// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The golden bags: one of each kind of job, replayed to the bit and planned again to the bit, by whatever has become of the program since.
//!
//! `CAMWRIGHT_GOLDEN="why" cargo test -p camwright_nodes --test replay golden_bags` runs the jobs anew and writes bags and table; the reason goes into the
//! bags and the table. It is for intended changes of the machine's behaviour.
#![allow(clippy::print_stdout, reason = "--nocapture shows what was replayed")]

use crate::changed_bag;
use crate::support;

use camwright_analysis::replan::{archived_jobs, replan};
use camwright_analysis::rerun::{ReplayVerdict, Window, rerun, within};
use camwright_bag::{Bag, BagMessage, BagWriter, Preset, RecordingOutcome, WriterOptions};
use changed_bag::Original;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::{Domain, Folder};

/// A kind of job, and how it is made small.
struct Golden {
    name: &'static str,
    kind: &'static str,
    job: &'static str,
    set: &'static [&'static str],
}

const GOLDEN: [Golden; 4] = [
    Golden {
        name: "ground",
        kind: "ground lobe",
        job: "eccentric",
        set: &["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"],
    },
    Golden {
        name: "runout",
        kind: "journal of a bent shaft, measured and corrected",
        job: "journal_runout",
        set: &["lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0, width_mm: 20}]"],
    },
    Golden {
        name: "turned",
        kind: "turned cam",
        job: "turned_cam",
        set: &["turned.to_mm=23", "form_grid.azimuths=180", "finishing.along_z_mm=0.3", "roughing.along_z_mm=0.8"],
    },
    Golden {
        name: "program",
        kind: "lobe ground by an NC program",
        job: "eccentric",
        set: &["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"],
    },
];

/// Topics needed to recompute a run and to replan its job, and those that show differences.
const TOPICS: [&str; 11] = [
    "/axis_interpolator/inputs",
    "/job_planner/job_files",
    "/job_planner/job_status",
    "/job_planner/lobe_forms",
    "/job_planner/plan",
    "/machine/alarms",
    "/machine/description",
    "/machine/inputs",
    "/machine/keyframes",
    "/machine/setpoints",
    "/machine/stream",
];

const REASON: &str = "camwright.golden";

fn folder() -> PathBuf {
    support::repository().join("bags/golden")
}

/// One line of the table.
fn line(golden: &Golden, bag: &Bag, verdict: &ReplayVerdict) -> String {
    let (digests, last) = verdict.digests;
    let reason = bag.custom_data().get(REASON).map_or("", String::as_str);
    let (ticks, setpoints, motions) = (verdict.ticks, verdict.setpoints, verdict.motions);
    let jobs = golden.set.join(" ");
    format!(
        "| `{}` | {} | `{}` {jobs} | {ticks} | {setpoints} of {motions} | {digests}, `{last:016x}` | {reason} |",
        golden.name, golden.kind, golden.job
    )
}

fn table(lines: &[String]) -> String {
    let mut text = String::from(
        "| bag | content | job | ticks | setpoints, motions | digests, last one | reason |\n|---|---|---|---|---|---|---|\n",
    );
    for line in lines {
        writeln!(text, "{line}").expect("a text grows");
    }
    text
}

const HEAD: &str = "# Golden bags

Small recorded runs, one of each kind of job. They hold the inputs and outputs of the machine, without data for people only.

`cargo test -p camwright_nodes --test replay golden_bags` computes each run again from its inputs (`camwright replay BAG --against`) and plans
its job again (`camwright replan bags/golden`). Both must be the same to the bit.

After an intended change of the machine's motion, write the bags and this table again, with the reason:

```sh
CAMWRIGHT_GOLDEN=\"reason of the change\" cargo test -p camwright_nodes --test replay golden_bags
```

";

/// Runs the job, and keeps of its bag what is golden.
fn make(golden: &Golden, reason: &str) {
    let work = Folder::new(&format!("golden-{}", golden.name));
    let mut set: Vec<String> = golden.set.iter().map(ToString::to_string).collect();
    if golden.name == "program" {
        let mut post = Command::new(env!("CARGO_BIN_EXE_camwright"));
        post.current_dir(work.path()).args(["post", golden.job, "--out", "."]);
        for over in &set {
            post.args(["--set", over]);
        }
        let output = post.output().expect("camwright runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        set.push("program=eccentric.ngc".to_owned());
    }
    let bag = work.join("whole");
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(work.path()).env("ROS_DOMAIN_ID", Domain::reserve().id().to_string());
    command.env("XDG_STATE_HOME", work.join("state")).args(["run", golden.job, "--bag", "whole"]);
    for over in &set {
        command.args(["--set", over]);
    }
    let output = command.output().expect("camwright runs");
    // A part that is not good, as one that burns, is a whole run all the same.
    let is_whole = matches!(output.status.code(), Some(0 | 4));
    assert!(is_whole, "{}: {}", golden.name, String::from_utf8_lossy(&output.stderr));
    store(&bag, &folder().join(golden.name), reason);
}

fn store(whole: &Path, into: &Path, reason: &str) {
    let _not_there = std::fs::remove_dir_all(into);
    let bag = Bag::open(whole).expect("a bag");
    let mut custom_data = bag.custom_data().clone();
    custom_data.insert(REASON.to_owned(), reason.to_owned());
    let options = WriterOptions { preset: Preset::Zstd, custom_data, ..WriterOptions::default() };
    let mut writer = BagWriter::create(into, &options).expect("a new bag");
    let ids: Vec<_> = bag
        .topics()
        .iter()
        .map(|topic| TOPICS.contains(&topic.name.as_str()).then(|| writer.add_topic(topic).expect("a topic")))
        .collect();
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message().expect("a readable bag") {
        if let Some(id) = ids[message.topic] {
            let BagMessage { log_time_ns, publish_time_ns, data, .. } = &message;
            writer.write(id, *log_time_ns, *publish_time_ns, data).expect("room");
        }
    }
    writer.close(RecordingOutcome::Complete, 0).expect("closed");
}

#[test]
fn every_golden_bag_is_computed_and_planned_again_to_the_bit() {
    let anew = std::env::var("CAMWRIGHT_GOLDEN");
    if let Ok(reason) = &anew {
        assert!(reason.len() > 10, "say why the golden bags are made anew");
        GOLDEN.iter().for_each(|golden| make(golden, reason));
    }
    let lines: Vec<String> = GOLDEN.iter().map(replayed).collect();
    let (file, text) = (folder().join("README.md"), format!("{HEAD}{}", table(&lines)));
    if anew.is_ok() {
        std::fs::write(&file, &text).expect("a table");
    }
    let written = std::fs::read_to_string(&file).expect("the table of the golden bags");
    assert_eq!(written, text, "the table is of other bags");
    // Nothing lies there that is not looked at.
    let inside = std::fs::read_dir(folder()).expect("a folder").flatten().filter(|entry| entry.path().is_dir());
    assert_eq!(inside.count(), GOLDEN.len());
}

fn replayed(golden: &Golden) -> String {
    let path = folder().join(golden.name);
    let verdict = rerun(&path).unwrap_or_else(|error| panic!("{}: {error}", golden.name));
    println!("{}: {}", golden.name, verdict.to_text());
    assert!(verdict.is_identical(), "{}: {}", golden.name, verdict.to_text());
    assert!(verdict.setpoints > 1000 && verdict.digests.0 > 3, "{}: {}", golden.name, verdict.to_text());
    from_every_keyframe(&path, &verdict);
    let jobs = archived_jobs(&path).expect("a bag");
    assert_eq!(jobs.len(), 1, "{}", golden.name);
    let outcome = replan(&jobs[0], &[], &[], 0.0).unwrap_or_else(|reason| panic!("{}: {reason}", golden.name));
    println!("{}: {outcome}", golden.name);
    assert!(outcome.is_same && outcome.hashes[0] == outcome.hashes[1], "{}: {outcome}", golden.name);
    line(golden, &Bag::open(&path).expect("a bag"), &verdict)
}

/// The run is the same from each of its keyframes on: this program still reads what that one wrote.
fn from_every_keyframe(path: &Path, whole: &ReplayVerdict) {
    let heads = Original::read(path, PathBuf::new()).keyframes();
    assert!(!heads.is_empty() && whole.keyframes == heads.len(), "{} of {} keyframes", whole.keyframes, heads.len());
    for head in heads {
        let verdict = within(path, Window { from_tick: Some(head.tick), to_tick: None });
        let verdict = verdict.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(verdict.is_identical() && verdict.begun == head.tick, "{}: {}", path.display(), verdict.to_text());
        assert_eq!(verdict.ticks + head.tick, whole.ticks);
        assert!(verdict.digests.0 == 0 || verdict.digests.1 == whole.digests.1, "{}", verdict.to_text());
    }
}

/// Keyframes with a state that harms, and a check that fits it: a replay says what is wrong with it, or that the machine goes another
/// way; it does not fail. `CAMWRIGHT_MUTATIONS=2000 cargo test -p camwright_nodes --test replay golden_bags harms` tries more.
#[test]
fn no_state_harms_a_replay() {
    let tries = std::env::var("CAMWRIGHT_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(40);
    let mut seed = 2026_u64;
    println!("seed {seed}");
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(seed >> 33).expect("31 bits") % below
    };
    let words =
        [u64::MAX, 1 << 53, (1 << 31) - 1, 0, f64::INFINITY.to_bits(), 1e15_f64.to_bits(), (-1e9_f64).to_bits()];
    for name in ["ground", "turned"] {
        let work = Folder::new(&format!("harmful-{name}"));
        let original = Original::read(&folder().join(name), work.join("changed"));
        let head = original.keyframes().remove(0);
        let state = original.state(&head);
        let window = Window { from_tick: Some(head.tick), to_tick: Some(head.tick + 100) };
        let (mut refused, mut differing, mut same) = (0, 0, 0);
        for _ in 0..tries {
            let mut changed = state.clone();
            for _ in 0..=random(2) {
                // Half of it where everything but the part stands: before it and behind it.
                let at = match random(4) {
                    0 => random(1200),
                    1 => state.len() - 8 - random(4000),
                    _ => random(state.len() - 8),
                };
                match random(2) {
                    0 => changed[at] ^= 1 << random(8),
                    _ => changed[at..at + 8].copy_from_slice(&words[random(words.len())].to_le_bytes()),
                }
            }
            match within(original.with_state(&head, &changed, true), window) {
                Err(_) => refused += 1,
                Ok(verdict) if verdict.is_identical() => same += 1,
                Ok(_) => differing += 1,
            }
        }
        println!("{name}: of {tries} states {refused} were refused, {differing} went another way, {same} did not show");
        assert!(refused > 0 && differing > 0, "{name}: {refused} refused, {differing} went another way");
    }
}
