// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cost of a cell that does nothing: processor time of each kind of thread, and octets recorded, at pace realtime.
//!
//! `cargo run --release -p camwright_nodes --example idle_cost -- [SECONDS]` (default 20) prints the figures.

#![allow(clippy::print_stdout, reason = "a command that prints its figures")]

use camwright_axis_interpolator::AxisInterpolator;
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_ros::{ParameterValue, RosArgs, RosLayer};
use camwright_run_logger::RunLogger;
use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Time after which the cost of starting is over.
const WARM_UP: Duration = Duration::from_secs(8);
/// Ticks of /proc a second.
const TICKS_S: f64 = 100.0;

/// Processor time of the threads of this process so far (s), by their name, and their voluntary switches.
fn threads() -> BTreeMap<String, (f64, u64)> {
    let mut all = BTreeMap::<String, (f64, u64)>::new();
    for task in fs::read_dir("/proc/self/task").into_iter().flatten().flatten() {
        let read = |file: &str| fs::read_to_string(task.path().join(file)).unwrap_or_default();
        let (stat, status) = (read("stat"), read("status"));
        let Some((before, fields)) = stat.rsplit_once(')') else { continue };
        let name = before.split_once('(').map_or("", |(_, name)| name).to_owned();
        let fields: Vec<f64> = fields.split_whitespace().map(|field| field.parse().unwrap_or(0.0)).collect();
        let switches =
            status.lines().find_map(|line| line.strip_prefix("voluntary_ctxt_switches:")?.trim().parse().ok());
        let entry = all.entry(name).or_default();
        entry.0 += (fields.get(11).unwrap_or(&0.0) + fields.get(12).unwrap_or(&0.0)) / TICKS_S;
        entry.1 += switches.unwrap_or(0);
    }
    all
}

/// Octets of the files in a folder and its folders.
fn octets(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(
            |entry| if entry.path().is_dir() { octets(&entry.path()) } else { entry.metadata().map_or(0, |m| m.len()) },
        )
        .sum()
}

fn main() -> Result<(), Box<dyn Error>> {
    let seconds: f64 = std::env::args().nth(1).map_or(Ok(20.0), |text| text.parse())?;
    RosLayer::install();
    let folder = std::env::temp_dir().join(format!("camwright-idle-{}", std::process::id()));
    let text = |text: &str| ParameterValue::String(text.to_owned());
    let args = RosArgs::from_env()?
        .0
        .with_parameter(Some("machine_sim"), "pace", text("realtime"))
        .with_parameter(Some("machine_sim"), "state_file", text("none"))
        .with_parameter(Some("run_logger"), "bag_dir", text(&folder.to_string_lossy()));
    let logger = RunLogger::start(&args)?;
    let machine = MachineSim::start(&args)?;
    let interpolator = AxisInterpolator::start(&args)?;
    let planner = JobPlanner::start(&args)?;
    std::thread::sleep(WARM_UP);

    let (before, recorded, began) = (threads(), octets(&folder), Instant::now());
    std::thread::sleep(Duration::from_secs_f64(seconds));
    let (after, recorded, took_s) = (threads(), octets(&folder) - recorded, began.elapsed().as_secs_f64());
    let mut used: Vec<(f64, f64, &str)> = after
        .iter()
        .map(|(name, (s, switches))| {
            let (s_before, switches_before) = before.get(name).copied().unwrap_or_default();
            (
                100.0 * (s - s_before) / took_s,
                (switches - switches_before.min(*switches)) as f64 / took_s,
                name.as_str(),
            )
        })
        .collect();
    used.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (percent, switches, name) in used.iter().filter(|(percent, switches, _)| *percent >= 0.05 || *switches >= 5.0) {
        println!("{percent:6.2} % of a core {switches:8.0} wake-ups/s  {name}");
    }
    let all: f64 = used.iter().map(|(percent, ..)| percent).sum();
    println!("{all:6.2} % of a core in all; {:.1} GB recorded a day", recorded as f64 / took_s * 86400.0 * 1e-9);
    planner.stop();
    interpolator.stop();
    machine.stop();
    logger.stop();
    fs::remove_dir_all(&folder)?;
    Ok(())
}
