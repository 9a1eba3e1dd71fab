// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Latencies between our nodes, beside the same on other stacks: `cargo bench -p camwright_nodes --bench latency`.
//!
//! Options after `--`: `--quick` (few samples), `--only-cell` (no responders), `--seed N`. Ctrl-C prints what there is. What each row is
//! stands in `tests/benchmarks/README.md`. Ends with 1 where a row lacks samples; durations are not checked.
#![allow(clippy::print_stdout, reason = "a command")]
#![allow(unreachable_pub, reason = "a binary has no outside")]

mod asker;
mod cell;
#[path = "../computer.rs"]
mod computer;
mod figures;
mod stops;
#[path = "../../support/mod.rs"]
mod support;
mod twins;

use asker::Asker;
use cell::{CellProcesses, Watch};
use computer::{computer, first_line};
use figures::{Row, table};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use support::{Domain, PeerEnv, peer_env};
use twins::{Messages, Stack, Twin};

/// Questions to a twin, each a row.
const TWIN_PATHS: [&str; 6] = [
    "chunk published → answer leaves",
    "chunk published → answer here",
    "edge published → stop leaves",
    "edge published → stop here",
    "e-stop called → answer here",
    "goal sent → answer here",
];
const LIMIT_PATHS: [&str; 3] =
    ["switch closes → X is 1 % slower", "from there → all at rest", "switch closes → all at rest"];
const ESTOP_PATHS: [&str; 4] = [
    "e-stop called → answer here",
    "e-stop called → tick that acts is told",
    "from that tick → all at rest",
    "e-stop called → rest is told",
];
/// Headings, and how the paths begin that stand below each.
const TABLES: [(&str, &[&str]); 4] = [
    ("Chunk of setpoints → machine", &["chunk"]),
    ("run_job: goal → accepted", &["goal"]),
    ("Limit switch → zero velocity", &["switch", "from there", "edge"]),
    ("E-stop → zero velocity", &["e-stop", "from that"]),
];
/// A job with one lobe: its plan is most of what is waited for.
const JOB: &str = "brake_cam";

/// Number of samples of each kind.
struct Counts {
    messages: usize,
    goals: usize,
    /// Number for each speed.
    limits: usize,
    estops: usize,
}

const FULL: Counts = Counts { messages: 1000, goals: 200, limits: 34, estops: 100 };
const QUICK: Counts = Counts { messages: 50, goals: 10, limits: 2, estops: 4 };

struct Options {
    counts: Counts,
    seed: u64,
    only_cell: bool,
}

impl Options {
    fn read() -> Self {
        let words: Vec<String> = std::env::args().skip(1).collect();
        let quick = words.iter().any(|word| word == "--quick");
        let after = words.iter().position(|word| word == "--seed").and_then(|at| words.get(at + 1));
        Self {
            counts: if quick { QUICK } else { FULL },
            seed: after.and_then(|word| word.parse().ok()).unwrap_or(20_261_122),
            only_cell: words.iter().any(|word| word == "--only-cell"),
        }
    }
}

fn machine_rows(options: &Options, interrupted: &Arc<AtomicBool>) -> Vec<Row> {
    let counts = &options.counts;
    let domain = Domain::reserve();
    let _cell = CellProcesses::start(&domain);
    let mut asker = Asker::new(&domain, options.seed, interrupted);
    let watch = Watch::new(&asker);
    let mut chunk =
        TWIN_PATHS[..2].iter().map(|path| Row::new(path, "machine_sim", counts.messages)).collect::<Vec<_>>();
    let [one_way, round_trip] = &mut chunk[..] else { return Vec::new() };
    cell::send_chunks(&mut asker, &watch, &Messages::new().chunk, [one_way, round_trip]);
    let mut goal = Row::new("goal sent → accepted, planning included", "job_planner", counts.goals);
    cell::run_jobs(&mut asker, JOB, &mut goal);
    let mut limits: Vec<Row> = stops::SPEEDS
        .iter()
        .flat_map(|(_, speed)| {
            LIMIT_PATHS.map(|path| Row::new(path, format!("machine_sim, X at {speed}"), counts.limits))
        })
        .collect();
    let mut estops = ESTOP_PATHS.map(|path| Row::new(path, "machine_sim", counts.estops)).to_vec();
    stops::limits_and_estops(&mut asker, &watch, &mut limits, &mut estops);
    let (octets, count) = watch.usual_chunk();
    println!("chunks on the way to the machine: {count}, median {octets} octets");
    chunk.into_iter().chain([goal]).chain(limits).chain(estops).collect()
}

fn twin_rows(options: &Options, env: Option<&PeerEnv>, interrupted: &Arc<AtomicBool>) -> Vec<Row> {
    let messages = Messages::new();
    let mut rows = Vec::new();
    for stack in [Stack::Ours, Stack::Rclpy, Stack::Cyclone] {
        if stack != Stack::Ours && env.is_none() || interrupted.load(Ordering::Relaxed) {
            continue;
        }
        // A domain of its own for each: one that was killed stays in the graph for a while.
        let domain = Domain::reserve();
        let twin = Twin::start(stack, env, &domain, &messages);
        let mut asker = Asker::new(&domain, options.seed, interrupted);
        rows.extend(twins::ask(&mut asker, &twin, &messages, [options.counts.messages, options.counts.goals]));
        if let (Some(env), true) = (env.filter(|_| stack != Stack::Ours), asker.goes_on()) {
            let who = format!("{}, asked by its like", twin.name);
            let mut own = [1, 3, 4].map(|path| Row::new(TWIN_PATHS[path], &who, options.counts.messages));
            twin.asked_by_its_like(env, &domain, &messages, &mut own.each_mut());
            rows.extend(own);
        }
    }
    rows
}

fn main() -> ExitCode {
    if std::env::args().nth(1).is_some_and(|word| word == twins::ANSWER) {
        twins::answer();
        return ExitCode::SUCCESS;
    }
    let options = Options::read();
    let interrupted = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGINT, Arc::clone(&interrupted)).expect("a signal handler");
    let env = if options.only_cell { None } else { peer_env() };
    let (start, load) = (Instant::now(), first_line("/proc/loadavg"));
    let mut rows = machine_rows(&options, &interrupted);
    if !options.only_cell {
        rows.extend(twin_rows(&options, env, &interrupted));
    }
    println!("{}; seed {}; took {:.0} s", computer(), options.seed, start.elapsed().as_secs_f64());
    println!("load before: {load}; after: {}", first_line("/proc/loadavg"));
    let messages = Messages::new();
    println!(
        "octets: chunk {}, stream {}, edge {}, stop {}",
        twins::size(&messages.chunk),
        twins::size(&messages.stream),
        twins::size(&messages.edge),
        twins::size(&messages.stop)
    );
    for (heading, beginnings) in TABLES {
        let belongs = |row: &&Row| beginnings.iter().any(|beginning| row.path.starts_with(beginning));
        println!("\n**{heading}**\n\n{}", table(rows.iter().filter(belongs)));
    }
    let incomplete: Vec<&Row> = rows.iter().filter(|row| !row.is_complete()).collect();
    for row in &incomplete {
        eprintln!("{} of {}: {} samples of {}, {} lost", row.path, row.who, row.times.len(), row.wanted, row.lost);
    }
    ExitCode::from(u8::from(!incomplete.is_empty()))
}
