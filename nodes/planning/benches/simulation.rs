// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Steps of the simulated machines and the sweeps of their tools: `cargo bench -p camwright_planning --bench simulation`.
//!
//! A step is a tick of interpolator and machine in the middle of the cut, on a copy of the same state each time; a sweep is a tick of the tool
//! alone.

mod benchmark_jobs;

use benchmark_jobs::Benchmark;
use camwright::math::units::TURN_RAD;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::turned_part::{Insert, InsertMove, InsertPose, PartGrid, TurnedPart};
use camwright::simulation::workpiece::{Lobe, WheelCentre};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};

/// Ticks of a measurement: a turn of C at 60 rpm on the grinder.
const TICKS: u32 = 1000;

/// The job with its machine as it is after so many ticks with a removal.
fn in_the_cut(benchmark: &Benchmark, ticks: u32) -> ClosedLoop {
    let mut closed_loop = benchmark.start(&benchmark.machine()).expect("a job that runs");
    let mut cut = 0;
    while cut < ticks {
        cut += u32::from(closed_loop.step(&[]).removal.area_mm2 > 0.0);
    }
    closed_loop
}

fn step(criterion: &mut Criterion) {
    let jobs = [("ground", Benchmark::ground()), ("turned", Benchmark::turned())];
    for (name, benchmark) in jobs {
        let ready = in_the_cut(&benchmark.expect("a plan"), 4000);
        criterion.bench_function(&format!("step/{name}, {TICKS} ticks"), |bencher| {
            let run = |mut closed_loop: ClosedLoop| {
                for _ in 0..TICKS {
                    closed_loop.step(&[]);
                }
                closed_loop
            };
            bencher.iter_batched(|| ready.clone(), run, BatchSize::PerIteration);
        });
    }
}

/// Positions of a wheel about a round lobe at 0.045 mm from each other, a turn with 36 µm of infeed.
fn sweep_lobe(criterion: &mut Criterion) {
    let lobe = Lobe::new(String::from("L"), 0, 14.0, vec![16.0; 3600]).expect("a lobe");
    criterion.bench_function("sweep/lobe, a turn", |bencher| {
        let turn = |mut lobe: Lobe| {
            for k in 0..10_600_u32 {
                let turns = f64::from(k) / 10_600.0;
                lobe.pass(
                    WheelCentre { azimuth_rad: TURN_RAD * turns, centre_mm: 76.0 - 0.036 * turns, radius_mm: 60.0 },
                    true,
                );
            }
            lobe
        };
        bencher.iter_batched(|| lobe.clone(), turn, BatchSize::PerIteration);
    });
}

/// Steps of 0.25 ms of an insert along an eccentric bar at 400 rpm, ten turns in feed.
fn sweep_bar(criterion: &mut Criterion) {
    let grid = PartGrid { azimuths: 720, columns: 601, from_mm: 0.0, to_mm: 12.0 };
    let bar = TurnedPart::round(String::from("bar"), grid, 22.0).expect("a bar");
    let insert = Insert { radius_mm: 8.0, height_mm: -14.0 };
    let pose = |turned_rad: f64| InsertPose {
        turned_rad,
        x_mm: 24.0 + 2.0 * turned_rad.cos(),
        z_mm: 6.0 + 0.2 * turned_rad / TURN_RAD,
    };
    criterion.bench_function("sweep/bar, ten turns", |bencher| {
        let turns = |mut bar: TurnedPart| {
            for k in 0..6000_u32 {
                let at = |k: u32| TURN_RAD * f64::from(k) / 600.0;
                bar.sweep(&insert, &InsertMove::straight(pose(at(k)), pose(at(k + 1))), true);
            }
            bar
        };
        bencher.iter_batched(|| bar.clone(), turns, BatchSize::PerIteration);
    });
}

criterion_group! {
    name = simulation;
    config = Criterion::default().sample_size(20);
    targets = step, sweep_lobe, sweep_bar
}
criterion_main!(simulation);
