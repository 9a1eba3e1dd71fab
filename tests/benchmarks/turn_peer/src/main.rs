// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Planning time of the fastest turn beside copp's TOPP2-RA, on the same tasks, in one process, alternating.
//!
//! ```text
//! cargo run --release --manifest-path tests/benchmarks/turn_peer/Cargo.toml [-- --runs 41 --random 20 --seed 20261121]
//! ```
//!
//! Our turn keeps jerk and is proven between its knots; the peer's keeps velocity and acceleration at 3600 points. The peer runs
//! twice: `tables` gives it path and bound as numbers, so that evaluating them costs nothing; `spline` evaluates the same path and
//! bound at its points, as our planner has to. Neither uses threads; times are processor
//! time. A ratio is the median over the rounds of our time over the peer's in the same round.

#[path = "../../../../camwright/tests/cams/mod.rs"]
mod cams;
#[path = "../../../../camwright/tests/cams/turn_cases.rs"]
mod turn_cases;

use camwright::math::units::TURN_RAD;
use copp::robot::Robot;
use copp::solver::topp2_ra::{ReachSet2OptionsBuilder, Topp2ProblemBuilder, s_to_t_topp2, topp2_ra};
use nalgebra::DMatrix;
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;
use std::hint::black_box;
use turn_cases::{C, Case, cases};

/// Intervals of the peer.
const INTERVALS: u32 = 3600;

/// Path and bound at the points of the peer.
struct PathTable {
    s: Vec<f64>,
    q: DMatrix<f64>,
    dq: DMatrix<f64>,
    ddq: DMatrix<f64>,
    /// Largest square of C's speed.
    bound: Vec<f64>,
}

impl PathTable {
    fn new(case: &Case) -> Self {
        let count = INTERVALS as usize + 1;
        let s: Vec<f64> = (0..=INTERVALS).map(|i| f64::from(i) * TURN_RAD / f64::from(INTERVALS)).collect();
        let [mut q, mut dq, mut ddq] = [(); 3].map(|()| DMatrix::zeros(2, count));
        let mut bound = Vec::with_capacity(count);
        for (i, &angle) in s.iter().enumerate() {
            let x = case.path.sample(angle);
            (q[(0, i)], dq[(0, i)], ddq[(0, i)]) = (angle, 1.0, 0.0);
            (q[(1, i)], dq[(1, i)], ddq[(1, i)]) = (x.value, x.first, x.second);
            let speed = case.bound(x).min(C.velocity);
            let by_x = x.first / case.lobe.x.velocity;
            bound.push(1.0 / (1.0 / (speed * speed)).max(by_x * by_x));
        }
        Self { s, q, dq, ddq, bound }
    }

    /// Time of the peer's turn (s), with this square of the speed at both ends.
    fn turn_s(&self, case: &Case, seam: f64) -> Result<f64, Box<dyn Error>> {
        let count = self.s.len();
        let limit = [C.acceleration, case.lobe.x.acceleration];
        let lower = limit.map(|limit| -limit);
        let mut robot = Robot::with_capacity(2_usize, count);
        robot
            .with_s(self.s.as_slice())?
            .with_q(&self.q.as_view(), &self.dq.as_view(), &self.ddq.as_view(), None, 0)?
            .with_axial_acceleration((limit.as_slice(), count), (lower.as_slice(), count), 0)?;
        robot.constraints.with_constraint_1order(self.bound.as_slice(), 0)?;
        let seam = seam.min((1.0 - 1e-9) * self.bound[0]);
        let problem = Topp2ProblemBuilder::new(&robot, (0, count - 1), (seam, seam)).build()?;
        let squares = topp2_ra(&problem, &ReachSet2OptionsBuilder::new().build()?)?;
        Ok(s_to_t_topp2(&self.s, &squares, 0.0)?.0)
    }
}

/// Processor time of this process (ms): what others do on the computer does not count.
fn processor_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

fn timed<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let begin = processor_ms();
    let result = black_box(run());
    (processor_ms() - begin, result)
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

struct Options {
    runs: u32,
    random: u64,
    seed: u64,
}

fn options() -> Result<Options, Box<dyn Error>> {
    let mut options = Options { runs: 41, random: 20, seed: 20_261_121 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let number = words.next().ok_or_else(|| format!("{word} needs a number"))?;
        match word.as_str() {
            "--runs" => options.runs = number.parse()?,
            "--random" => options.random = number.parse()?,
            "--seed" => options.seed = number.parse()?,
            _ => return Err(format!("unknown option {word}; known: --runs, --random, --seed").into()),
        }
    }
    if options.runs == 0 {
        return Err("--runs is at least 1".into());
    }
    Ok(options)
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    println!("| task | turn s | peer's turn s | ours ms | tables ms | spline ms | ours / tables | ours / spline |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    let (mut by_tables, mut by_spline) = (Vec::new(), Vec::new());
    for case in &cases(options.random, options.seed)? {
        let turn = case.plan()?;
        let seam = turn.at(0.0).speed;
        let table = PathTable::new(case);
        let peer_s = table.turn_s(case, seam * seam)?;
        let (mut ours, mut tables, mut spline) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..options.runs {
            ours.push(timed(|| case.plan()).0);
            tables.push(timed(|| table.turn_s(case, seam * seam).ok()).0);
            spline.push(timed(|| PathTable::new(case).turn_s(case, seam * seam).ok()).0);
        }
        let ratio = |peer: &[f64]| median(&ours.iter().zip(peer).map(|(ours, peer)| ours / peer).collect::<Vec<_>>());
        let (of_tables, of_spline) = (ratio(&tables), ratio(&spline));
        by_tables.push(of_tables);
        by_spline.push(of_spline);
        println!(
            "| {} | {:.6} | {peer_s:.6} | {:.3} | {:.3} | {:.3} | {of_tables:.2} | {of_spline:.2} |",
            case.name,
            turn.turn_s(),
            least(&ours),
            least(&tables),
            least(&spline),
        );
    }
    println!();
    for (peer, ratios) in [("tables", &by_tables), ("spline", &by_spline)] {
        let largest = ratios.iter().copied().fold(0.0, f64::max);
        println!("ours / {peer}: median {:.2}, {:.2} to {largest:.2}", median(ratios), least(ratios));
    }
    Ok(())
}
