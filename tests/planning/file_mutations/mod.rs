// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files with something wrong in them: whatever stands in a job, machine, lift table, surface, program, parameter file or bag, a command
//! ends within its time and its memory, by its rule, and says why.
//!
//! A small slice runs with every `cargo test`. The campaign:
//!
//! ```text
//! CAMWRIGHT_MUTATIONS=20000 CAMWRIGHT_SEED=1 cargo test -p camwright_nodes --test planning file_mutations -- --ignored --nocapture
//! ```
//! `CAMWRIGHT_KINDS=jobs,bags` restricts it, `CAMWRIGHT_FIRST=4711` begins with a later case, `CAMWRIGHT_THREADS` sets how many run at a
//! time, `CAMWRIGHT_UNCHANGED=1` changes nothing, to see that what is changed is accepted as it is, `CAMWRIGHT_PROGRAM` names another build of the program. What fails is kept under `target/tmp/file_mutations`, with the command.

#![allow(clippy::print_stdout, reason = "a campaign reports its progress")]
#![allow(unreachable_pub, reason = "a test has no outside")]
#![allow(clippy::cast_possible_truncation, reason = "small numbers of a test")]

mod bags;
mod bounds;
use crate::changed_bag;
mod judge;
mod mutate;
mod random;
mod subjects;
use crate::support;

use judge::{End, Outcome};
use random::Random;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use subjects::{Kind, Subjects};
use support::{Folder, repository};

/// Cases of the slice that runs with every test.
const SLICE: u64 = 100;

struct Campaign {
    seed: u64,
    first: u64,
    count: u64,
    kinds: Vec<Kind>,
    threads: usize,
    program: PathBuf,
    kept: PathBuf,
    /// Files stay as they are.
    still: bool,
}

/// Ends of all commands of a kind, and the slowest.
#[derive(Debug, Default, Clone)]
struct Tally {
    ends: BTreeMap<End, u64>,
    slowest: (f64, u64),
}

impl Campaign {
    fn kind(&self, random: &mut Random) -> Kind {
        let sum: usize = self.kinds.iter().map(|kind| kind.weight()).sum();
        let mut left = random.below(sum);
        for kind in &self.kinds {
            if left < kind.weight() {
                return *kind;
            }
            left -= kind.weight();
        }
        self.kinds[0]
    }

    /// Runs all cases; the failures by case.
    fn run(&self) -> Vec<String> {
        let scratch = Folder::new("file-mutations");
        let subjects = Subjects::new(&repository(), &self.program, scratch.path());
        let next = AtomicU64::new(self.first);
        let tallies: Mutex<BTreeMap<Kind, Tally>> = Mutex::new(BTreeMap::new());
        let failures: Mutex<Vec<String>> = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for thread in 0..self.threads {
                let (subjects, next, tallies, failures, scratch) = (&subjects, &next, &tallies, &failures, &scratch);
                scope.spawn(move || {
                    let folder = scratch.join(&format!("thread-{thread}"));
                    loop {
                        let case = next.fetch_add(1, Ordering::Relaxed);
                        if case >= self.first + self.count {
                            return;
                        }
                        let (kind, command, outcome) = self.case(subjects, case, &folder);
                        let mut tallies = tallies.lock().expect("a tally");
                        let tally = tallies.entry(kind).or_default();
                        *tally.ends.entry(outcome.end).or_default() += 1;
                        if outcome.seconds > tally.slowest.0 {
                            tally.slowest = (outcome.seconds, case);
                        }
                        drop(tallies);
                        if !matches!(outcome.end, End::Rule(_)) {
                            failures
                                .lock()
                                .expect("failures")
                                .push(self.store_case(case, kind, &command, &outcome, &folder));
                        }
                        if self.still && outcome.end > End::Rule(1) {
                            println!("case {case}: {command:?} {}: {}", outcome.end, outcome.output);
                        }
                        if case % 500 == 499 {
                            println!("{} cases", case + 1);
                        }
                    }
                });
            }
        });
        for (kind, tally) in tallies.into_inner().expect("tallies") {
            let ends: Vec<String> = tally.ends.iter().map(|(end, count)| format!("{count} {end}")).collect();
            let (seconds, case) = tally.slowest;
            println!("{:<10} {}; slowest {seconds:.1} s (case {case})", kind.name(), ends.join(", "));
        }
        failures.into_inner().expect("failures")
    }

    fn case(&self, subjects: &Subjects, case: u64, folder: &Path) -> (Kind, Vec<String>, Outcome) {
        let _gone = fs::remove_dir_all(folder);
        fs::create_dir_all(folder).expect("room");
        let mut random = Random::new(self.seed, case);
        let kind = self.kind(&mut random);
        random = if self.still { random.still() } else { random };
        let command = subjects.prepare(kind, &mut random, folder);
        let outcome = judge::run(&self.program, &command, folder);
        (kind, command, outcome)
    }

    /// Keeps what failed; one line about it.
    fn store_case(&self, case: u64, kind: Kind, command: &[String], outcome: &Outcome, folder: &Path) -> String {
        let name = format!("{}_{case}_{}_{}", self.seed, kind.name(), outcome.end);
        let kept = self.kept.join(&name);
        let _gone = fs::remove_dir_all(&kept);
        let _kept = fs::create_dir_all(&self.kept).and_then(|()| fs::rename(folder, &kept));
        let text = format!(
            "camwright {}\n{} after {:.1} s\n{}\n",
            command.join(" "),
            outcome.end,
            outcome.seconds,
            outcome.output
        );
        let _kept = fs::write(kept.join("command_and_result.txt"), text);
        let place = outcome.output.lines().find(|line| line.contains("panicked at")).unwrap_or_default();
        let line =
            format!("{name}: camwright {}: {} after {:.1} s {place}", command.join(" "), outcome.end, outcome.seconds);
        println!("{line}");
        line
    }
}

fn kept() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("file_mutations")
}

#[test]
fn whatever_stands_in_a_file_a_command_ends_by_its_rule() {
    let campaign = Campaign {
        seed: 21,
        first: 0,
        count: SLICE,
        kinds: Kind::ALL.into(),
        threads: 2,
        program: env!("CARGO_BIN_EXE_camwright").into(),
        kept: kept(),
        still: false,
    };
    let failures = campaign.run();
    assert!(failures.is_empty(), "{} of {SLICE}:\n{}", failures.len(), failures.join("\n"));
}

#[test]
#[ignore = "takes hours: run it with CAMWRIGHT_MUTATIONS and CAMWRIGHT_SEED"]
fn campaign() {
    let number =
        |name: &str, default: u64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let kinds = std::env::var("CAMWRIGHT_KINDS").unwrap_or_default();
    let mut kinds: Vec<Kind> =
        Kind::ALL.into_iter().filter(|kind| kinds.split(',').any(|name| name == kind.name())).collect();
    if kinds.is_empty() {
        kinds = Kind::ALL.into();
    }
    let campaign = Campaign {
        seed: number("CAMWRIGHT_SEED", 1),
        first: number("CAMWRIGHT_FIRST", 0),
        count: number("CAMWRIGHT_MUTATIONS", 20_000),
        kinds,
        threads: number("CAMWRIGHT_THREADS", 2) as usize,
        program: std::env::var_os("CAMWRIGHT_PROGRAM")
            .map_or_else(|| env!("CARGO_BIN_EXE_camwright").into(), PathBuf::from),
        kept: kept(),
        still: number("CAMWRIGHT_UNCHANGED", 0) > 0,
    };
    let failures = campaign.run();
    println!("{} of {} cases of seed {} failed", failures.len(), campaign.count, campaign.seed);
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
