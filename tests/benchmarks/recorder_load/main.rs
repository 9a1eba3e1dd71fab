// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The recorder under load, beside one in Python: `cargo bench -p camwright_nodes --bench recorder_load`, options after `--` (`--help`).
//!
//! What each column is stands in `tests/benchmarks/README.md`. Ends with 1 where a message is not accounted for, or with `--cell` where
//! one is missing; durations are not checked.
#![allow(clippy::print_stdout, reason = "a command")]
#![allow(unreachable_pub, reason = "a binary has no outside")]

mod account;
mod cell;
#[path = "../computer.rs"]
mod computer;
mod jobs;
mod load;
mod our_layer;
mod python_recorder;
mod recorders;
#[path = "../../support/mod.rs"]
mod support;
mod usage;

use account::{Enqueue, ReportedLosses, disagreements, enqueue, lost};
use camwright_bag::Bag;
use clap::Parser;
use computer::{computer, first_line};
use indicatif::{ProgressBar, ProgressStyle};
use load::{Load, Publisher, Sent, Stack, TOPIC};
use python_recorder::PythonRecorder;
use recorders::{ResourceUse, RunLoggerProcess};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use support::{Domain, PeerEnv, peer_env};

/// Maximum delay until all processes know each other, after each has announced itself.
const ACQUAINTANCE: Duration = Duration::from_secs(1);

/// A load of messages from another DDS into `run_logger`, and into a recorder in Python; or with `--cell` the cell's own traffic.
#[derive(Parser)]
#[command(name = "recorder_load")]
struct Options {
    /// Messages a second
    #[arg(long, default_value_t = 50_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    rate: u64,
    /// For so many seconds
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=3600))]
    seconds: u64,
    /// Length of a message as it travels (octets)
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(24..=32_000))]
    bytes: u64,
    /// Whose DDS publishes; several in turn with commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "cyclone")]
    from: Vec<Stack>,
    /// Leave out the recorder in Python
    #[arg(long)]
    only_ours: bool,
    /// Record the whole cell at the wall clock's pace instead, and prove that nothing is missing
    #[arg(long)]
    cell: bool,
    /// With `--cell`: begin new jobs for so many minutes
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Keep the bags, and say where they are
    #[arg(long)]
    keep: bool,
    /// Cargo's own word
    #[arg(long, hide = true)]
    bench: bool,
}

/// One recording of one load.
struct Row {
    recorder: &'static str,
    publisher: String,
    load: Load,
    sent: Sent,
    received: u64,
    written: u64,
    /// Why, of our recorder.
    lost: Option<ReportedLosses>,
    enqueue: Option<Enqueue>,
    used: ResourceUse,
    bag_bytes: u64,
    wrong: Vec<String>,
}

fn size_of(directory: &Path) -> u64 {
    let entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some(entry.metadata().ok()?.len())).sum()
}

/// A bar that fills while the load lasts.
fn bar(load: &Load, recorder: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {elapsed} of {len} s");
    let bar = ProgressBar::new(load.seconds);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(format!("{:?}, {} → {recorder}", load.stack, load.reliability()));
    bar
}

fn publish(publisher: &mut Publisher, load: &Load, recorder: &str) -> Sent {
    let bar = bar(load, recorder);
    eprintln!("{:?}, {} → {recorder}: {} s", load.stack, load.reliability(), load.seconds);
    let begun = Instant::now();
    let sent = publisher.publish(|| bar.set_position(begun.elapsed().as_secs()));
    bar.finish_and_clear();
    sent
}

fn into_ours(load: Load, env: Option<&PeerEnv>, bag: &Path) -> Row {
    let domain = Domain::reserve();
    let recorder = RunLoggerProcess::start(&domain, bag, &[TOPIC]);
    let mut publisher = Publisher::start(load, env, &domain);
    publisher.wait_matched();
    recorder.wait_for_topics(&[TOPIC]);
    std::thread::sleep(ACQUAINTANCE);
    let sent = publish(&mut publisher, &load, "run_logger");
    let reported = recorder.wait_settled(sent.sent);
    let (bag, used) = recorder.end();
    let read = Bag::open(&bag).expect("it is closed");
    Row {
        recorder: "run_logger",
        publisher: publisher.name.clone(),
        load,
        sent,
        received: reported.received,
        written: reported.written,
        lost: Some(lost(&read)),
        enqueue: Some(enqueue(&read)),
        used,
        bag_bytes: size_of(&bag),
        wrong: disagreements(&bag, &sent, reported),
    }
}

fn into_twin(load: Load, env: &PeerEnv, bag: &Path) -> Row {
    let domain = Domain::reserve();
    let mut recorder = PythonRecorder::start(env, &domain, bag, &load);
    let mut publisher = Publisher::start(load, Some(env), &domain);
    publisher.wait_matched();
    recorder.wait_ready();
    std::thread::sleep(ACQUAINTANCE);
    let sent = publish(&mut publisher, &load, "Python");
    // It has no status: what is still on its way has these seconds.
    std::thread::sleep(3 * ACQUAINTANCE);
    let (reported, found, bag, used) = recorder.end();
    let mut wrong = Vec::new();
    if found.messages != reported.written || found.disordered + found.foreign != 0 {
        wrong.push(format!("{reported:?} and {found:?}"));
    }
    Row {
        recorder: "rclpy and mcap, Python",
        publisher: publisher.name.clone(),
        load,
        sent,
        received: reported.received,
        written: reported.written,
        lost: None,
        enqueue: None,
        used,
        bag_bytes: size_of(&bag),
        wrong,
    }
}

fn print(rows: &[Row]) {
    println!(
        "| recorder | publisher | QoS | sent | in s | received | lost on the way | by the socket | written | dropped | CPU s | \
         publisher's CPU s | peak MB | bag MB |\n|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
    );
    for row in rows {
        let dropped = row.received.saturating_sub(row.written);
        println!(
            "| {} | {} | {} | {} | {:.1} | {} | {} | {} | {} | {dropped} | {:.1} | {:.1} | {:.1} | {:.1} |",
            row.recorder,
            row.publisher,
            row.load.reliability().replace('_', " "),
            row.sent.sent,
            row.sent.took_s,
            row.received,
            row.sent.sent.saturating_sub(row.received),
            row.used.datagrams_dropped,
            row.written,
            row.used.cpu_s,
            row.sent.cpu_s,
            row.used.peak_kb as f64 / 1e3,
            row.bag_bytes as f64 / 1e6,
        );
    }
    println!("\n| enqueue of run_logger | p50 µs | p99 µs | p99.9 µs | max µs |\n|---|---:|---:|---:|---:|");
    for row in rows {
        let Some(times) = row.enqueue else { continue };
        let [p50, p99, p99_9, max] = times.map(|ns| ns as f64 / 1e3);
        let what = format!("{}, {}", row.publisher, row.load.reliability().replace('_', " "));
        println!("| {what} | {p50:.2} | {p99:.2} | {p99_9:.2} | {max:.0} |");
    }
    println!();
    for row in rows {
        if let Some(lost) = row.lost.filter(|lost| lost.total > 0) {
            println!("{}, {}: {lost:?}", row.publisher, row.load.reliability());
        }
        if row.sent.refused > 0 {
            println!("{}, {}: waited for room {} times", row.publisher, row.load.reliability(), row.sent.refused);
        }
    }
}

fn loads(options: &Options, bag: &Path) -> Vec<Row> {
    let needs_peers = !options.only_ours || options.from.iter().any(|&stack| stack != Stack::Ours);
    let env = needs_peers.then(peer_env).flatten();
    let mut rows = Vec::new();
    for &stack in &options.from {
        if stack != Stack::Ours && env.is_none() {
            continue;
        }
        for is_reliable in [false, true] {
            let octets = usize::try_from(options.bytes).expect("a short message");
            let load = Load { stack, is_reliable, octets, per_second: options.rate, seconds: options.seconds };
            rows.push(into_ours(load, env, bag));
            if let (Some(env), false) = (env, options.only_ours) {
                rows.push(into_twin(load, env, &bag.with_extension("python")));
            }
        }
    }
    rows
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().collect();
    if words.get(1).is_some_and(|word| word == load::PUBLISH) {
        our_layer::publish(&words[2..]);
        return ExitCode::SUCCESS;
    }
    let options = Options::parse();
    let bag = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("recorder-load-{}", std::process::id()));
    let (start, before) = (Instant::now(), first_line("/proc/loadavg"));
    let wrong: Vec<String> = if options.cell {
        jobs::campaign(&bag, Duration::from_secs_f64(options.minutes.clamp(0.0, 1e5) * 60.0))
    } else {
        let rows = loads(&options, &bag);
        print(&rows);
        rows.into_iter().flat_map(|row| row.wrong).collect()
    };
    println!(
        "{}, net.core.rmem_max {}; took {:.0} s; load before: {before}; after: {}",
        computer(),
        first_line("/proc/sys/net/core/rmem_max"),
        start.elapsed().as_secs_f64(),
        first_line("/proc/loadavg")
    );
    for path in [&bag, &bag.with_extension("python")] {
        if options.keep && path.exists() {
            println!("kept: {}", path.display());
        } else {
            let _not_made = std::fs::remove_dir_all(path);
        }
    }
    for text in &wrong {
        eprintln!("does not add up: {text}");
    }
    ExitCode::from(u8::from(!wrong.is_empty()))
}
