// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Speed of the simulated machines: `cargo run --release -p camwright_planning --example simulation_speed [RUNS [ground|turned]]`.
//!
//! Runs the default job of the grinder and the 3-D cam of the lathe, interpolator and machine in one loop on one core, as they are and
//! without the effects that leave an error on the part. Prints machine seconds per second, the best of RUNS (3): for the whole job, then for
//! its phases. The last line of each is the digest of every reading and of the part: equal digests are equal bits.
#![allow(clippy::print_stdout, reason = "a command: its output is the benchmark")]
#![allow(clippy::disallowed_methods, reason = "a benchmark measures time")]

#[path = "../benches/benchmark_jobs/mod.rs"]
mod benchmark_jobs;

use benchmark_jobs::Benchmark;
use camwright::machine::description::{Effect, MachineDescription};
use camwright::simulation::Machine;
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::workpiece::Lobe;
use std::collections::BTreeMap;
use std::error::Error;
use std::time::{Duration, Instant};

/// Work of the machine in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Phase {
    Cuts,
    Rubs,
    /// A lobe stands in front of the wheel.
    Near,
    Away,
}

impl Phase {
    fn from_report(report: &TickReport) -> Self {
        if report.removal.area_mm2 > 0.0 {
            Self::Cuts
        } else if report.normal_force_n > 0.0 {
            Self::Rubs
        } else if report.lobe.is_some() {
            Self::Near
        } else {
            Self::Away
        }
    }
}

/// FNV-1a by Fowler, Noll and Vo.
struct Digest(u64);

impl Digest {
    fn add(&mut self, value: u64) {
        self.0 = (self.0 ^ value).wrapping_mul(0x0100_0000_01b3);
    }

    fn add_part(&mut self, machine: &Machine) {
        let ground = machine.part().lobes().iter().flat_map(Lobe::radii_mm).copied();
        let turned = machine.turned_part().into_iter().flat_map(|part| part.radii_mm());
        ground.chain(turned).for_each(|radius_mm| self.add(radius_mm.to_bits()));
    }
}

/// The whole job once: its ticks and the time they took.
fn run(benchmark: &Benchmark, description: &MachineDescription) -> Result<(u32, Duration), Box<dyn Error>> {
    let mut closed_loop = benchmark.start(description)?;
    let mut ticks = 0;
    let begin = Instant::now();
    while closed_loop.is_running() {
        closed_loop.step(&[]);
        ticks += 1;
    }
    Ok((ticks, begin.elapsed()))
}

/// Ticks and time of every phase.
type Phases = BTreeMap<Phase, (u32, Duration)>;

/// The phases of the job, and the digest of the run.
fn run_by_phase(benchmark: &Benchmark, description: &MachineDescription) -> Result<(Phases, u64), Box<dyn Error>> {
    let mut closed_loop = benchmark.start(description)?;
    let mut phases = Phases::new();
    let mut digest = Digest(0xcbf2_9ce4_8422_2325);
    while closed_loop.is_running() {
        let begin = Instant::now();
        let report = closed_loop.step(&[]);
        let took = begin.elapsed();
        let (ticks, total) = phases.entry(Phase::from_report(&report)).or_default();
        (*ticks, *total) = (*ticks + 1, *total + took);
        for axis in report.axes {
            let floats = [axis.velocity, axis.effort, axis.following_error];
            digest.add(axis.counts.cast_unsigned());
            floats.into_iter().for_each(|value| digest.add(value.to_bits()));
        }
        digest.add(report.normal_force_n.to_bits());
    }
    digest.add_part(closed_loop.machine());
    Ok((phases, digest.0))
}

fn print_row(name: &str, cycle_time_s: f64, ticks: u32, took: Duration) {
    let machine_s = f64::from(ticks) * cycle_time_s;
    let (took_s, tick_us) = (took.as_secs_f64(), took.as_secs_f64() * 1e6 / f64::from(ticks));
    println!("  {name:<12} {machine_s:>7.2} s {took_s:>8.3} s {tick_us:>7.2} us/tick {:>6.0} x", machine_s / took_s);
}

fn measure(name: &str, benchmark: &Benchmark, runs: u32) -> Result<(), Box<dyn Error>> {
    let own = benchmark.machine();
    let ideal = Effect::ALL.iter().fold(own.clone(), |machine, effect| machine.without(*effect));
    for (effects, description) in [("all effects", own), ("no effects", ideal)] {
        let cycle_time_s = description.cycle_time_s();
        println!("{name}, {effects}: machine time, best time of {runs}, per tick, times real time");
        let mut best = run(benchmark, &description)?;
        for _ in 1..runs {
            best = best.min(run(benchmark, &description)?);
        }
        print_row("total", cycle_time_s, best.0, best.1);
        let (mut phases, digest) = run_by_phase(benchmark, &description)?;
        for _ in 1..runs {
            for (phase, (_, took)) in run_by_phase(benchmark, &description)?.0 {
                phases.entry(phase).and_modify(|(_, best)| *best = took.min(*best));
            }
        }
        for (phase, (ticks, took)) in phases {
            print_row(&format!("{phase:?}").to_lowercase(), cycle_time_s, ticks, took);
        }
        println!("  digest {digest:016x}");
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let runs = words.next().map_or(Ok(3), |word| word.parse::<u32>())?.max(1);
    let only = words.next();
    let wanted = |name: &str| only.as_deref().is_none_or(|only| only == name);
    if wanted("ground") {
        measure("four_lobe_camshaft on cam_grinder", &Benchmark::ground()?, runs)?;
    }
    if wanted("turned") {
        measure("turned_cam on lathe", &Benchmark::turned()?, runs)?;
    }
    Ok(())
}
