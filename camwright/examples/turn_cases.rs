//! Cases for the judges of the fastest turn (tests/benchmarks): the reference lobe and seeded random ones.
//!
//! ```text
//! turn_cases DIRECTORY RANDOM SEED      then, on standard input, lines "CASE RUNS"
//! ```
//!
//! Writes for every case the data that another planner needs to solve the same task, and the turn found here: `case_NN.txt`
//! words and numbers; `case_NN.grid.f64` rows of X, X′, X″, X‴ (mm over rad), the bound on C's speed, speed and acceleration
//! of the turn (rad/s, rad/s²), at equal angles from 0 on; `case_NN.time.f64` rows of C (rad) and X (mm) at equal times.
//! Both are little-endian doubles. It then plans cases on request and prints the time of each run in nanoseconds, for a
//! side-by-side comparison with another planner.
#![allow(clippy::print_stdout, reason = "a command: its output is what the benchmark reads")]

#[path = "../tests/cams/mod.rs"]
mod cams;

use cams::SplitMix64;
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::{LiftLaw, MotionProgram, MotionSegment};
use camwright::cam::motion_law::MotionLaw;
use camwright::machine::description::MotionLimits;
use camwright::math::hermite::Sample;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::motion::speed_plan::{TurnRequest, TurnSpeed};
use camwright::toolpath::wheel_path::ToolPath;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, BufRead, Write as _};
use std::path::Path;
use std::time::Instant;

/// Points of the grid that the judges get: 32 times the 3600 of the comparison, so that these are among them.
const GRID: u32 = 115_200;

/// Samples of the trajectory in time (1/s): the 1 kHz of the interpolator, eight times finer.
const SAMPLES_PER_S: f64 = 8000.0;

/// Steps of the integration from one sample to the next. C's jerk jumps at the knots, where a step is of third order only;
/// with 64 its error is some 1e-5 of the jerk limit once it has been differenced three times.
const STEPS_PER_SAMPLE: u32 = 64;

const C: MotionLimits = MotionLimits { velocity: 10.0 * std::f64::consts::PI, acceleration: 300.0, jerk: 3e4 };
const LINEAR_MOTOR: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 };
const BALL_SCREW: MotionLimits = MotionLimits { velocity: 170.0, acceleration: 3e3, jerk: 1e5 };

/// A lobe, its wheel, what is taken off, and what X can do.
#[derive(Debug, Clone, Copy)]
struct Lobe {
    law: MotionLaw,
    follower: Follower,
    base_radius_mm: f64,
    lift_mm: f64,
    rise_deg: f64,
    fall_deg: f64,
    wheel_radius_mm: f64,
    removal_rate_mm2_s: f64,
    infeed_mm: f64,
    x: MotionLimits,
}

impl Lobe {
    /// The lobe of the acceptance test (`camwright/tests/motion/fastest_turn.rs`).
    const fn reference(wheel_radius_mm: f64, removal_rate_mm2_s: f64, infeed_mm: f64) -> Self {
        Self {
            law: MotionLaw::Polynomial345,
            follower: Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 },
            base_radius_mm: 16.0,
            lift_mm: 6.0,
            rise_deg: 62.0,
            fall_deg: 62.0,
            wheel_radius_mm,
            removal_rate_mm2_s,
            infeed_mm,
            x: LINEAR_MOTOR,
        }
    }

    fn contour(&self) -> Option<Contour> {
        let segment = |law, angle_rad, rise_mm| MotionSegment { law, angle_rad, rise_mm };
        let (rise, fall) = (rad_from_deg(self.rise_deg), rad_from_deg(self.fall_deg));
        let segments = [
            segment(self.law, rise, self.lift_mm),
            segment(self.law, fall, -self.lift_mm),
            segment(MotionLaw::Dwell, TURN_RAD - rise - fall, 0.0),
        ];
        let program = MotionProgram::new(0.5 * TURN_RAD - rise, &segments).ok()?;
        Contour::from_lift(&LiftLaw::from_program(program).ok()?, &self.follower, self.base_radius_mm).ok()
    }

    /// The first lobe that can be ground, among those drawn from a seed.
    fn random(seed: u64) -> (Self, ToolPath) {
        let mut random = SplitMix64(seed);
        loop {
            let mut lobe = Self {
                law: if random.next() >> 63 == 1 { MotionLaw::Polynomial345 } else { MotionLaw::Polynomial4567 },
                follower: if random.next() >> 63 == 1 {
                    Follower::Roller { radius_mm: random.within(5.0, 20.0), offset_mm: 0.0 }
                } else {
                    Follower::Flat
                },
                base_radius_mm: random.within(12.0, 25.0),
                lift_mm: random.within(3.0, 10.0),
                rise_deg: random.within(50.0, 80.0),
                fall_deg: random.within(50.0, 80.0),
                wheel_radius_mm: 0.0,
                removal_rate_mm2_s: random.within(2.0, 20.0),
                infeed_mm: random.within(0.01, 0.05),
                x: if random.next() >> 63 == 1 { LINEAR_MOTOR } else { BALL_SCREW },
            };
            let wheel = random.within(0.0, 1.0);
            let Some(contour) = lobe.contour() else { continue };
            let largest = contour.recommended_wheel_radius_mm().unwrap_or(f64::INFINITY).min(250.0);
            if largest < 30.0 {
                continue;
            }
            lobe.wheel_radius_mm = 30.0 + (largest - 30.0) * wheel;
            if let Ok(path) = ToolPath::for_wheel(&contour, lobe.wheel_radius_mm) {
                return (lobe, path);
            }
        }
    }
}

struct Case {
    name: String,
    lobe: Lobe,
    path: ToolPath,
}

impl Case {
    /// The speed that the removal rate allows (rad/s).
    fn bound(&self, x: Sample) -> f64 {
        let cutting = cams::cutting(self.lobe.wheel_radius_mm, self.lobe.infeed_mm);
        self.lobe.removal_rate_mm2_s / cutting.removal_rate_ratio_mm2(x)
    }

    fn plan(&self) -> Result<TurnSpeed, Box<dyn Error>> {
        let bound = |_: f64, x: Sample| self.bound(x);
        let path = self.path.spline();
        let request = TurnRequest { path, infeed_slope_mm_rad: 0.0, bound: &bound, c: C, x: self.lobe.x };
        Ok(TurnSpeed::fastest(&request)?)
    }

    fn write(&self, directory: &Path, index: usize) -> Result<(), Box<dyn Error>> {
        let turn = self.plan()?;
        let mut grid = Vec::new();
        for i in 0..GRID {
            let angle = f64::from(i) * (TURN_RAD / f64::from(GRID));
            let (x, c) = (self.path.sample(angle), turn.at(angle));
            for number in [x.value, x.first, x.second, x.third, self.bound(x), c.speed, c.acceleration] {
                grid.extend(number.to_le_bytes());
            }
        }
        fs::write(directory.join(format!("case_{index:02}.grid.f64")), grid)?;

        let mut times = Vec::new();
        for (c, x) in self.in_time(&turn) {
            times.extend(c.to_le_bytes());
            times.extend(x.to_le_bytes());
        }
        fs::write(directory.join(format!("case_{index:02}.time.f64")), times)?;

        let mut words = String::new();
        writeln!(words, "name {}", self.name)?;
        writeln!(words, "input {:?}", self.lobe)?;
        for (axis, limits) in [("c", C), ("x", self.lobe.x)] {
            writeln!(words, "{axis}_velocity {:e}", limits.velocity)?;
            writeln!(words, "{axis}_acceleration {:e}", limits.acceleration)?;
            writeln!(words, "{axis}_jerk {:e}", limits.jerk)?;
        }
        writeln!(words, "sample_s {:e}", 1.0 / SAMPLES_PER_S)?;
        writeln!(words, "turn_s {:e}", turn.turn_s())?;
        writeln!(words, "least_s {:e}", turn.minimum_s())?;
        fs::write(directory.join(format!("case_{index:02}.txt")), words)?;
        Ok(())
    }

    /// C and X over a turn and a tenth of one, at equal times, by integrating the speed over the angle.
    fn in_time(&self, turn: &TurnSpeed) -> Vec<(f64, f64)> {
        let step = 1.0 / (SAMPLES_PER_S * f64::from(STEPS_PER_SAMPLE));
        let speed = |angle: f64| turn.at(angle).speed;
        let mut angle = 0.0;
        let mut samples = Vec::new();
        while angle < 1.1 * TURN_RAD {
            samples.push((angle, self.path.sample(angle).value));
            for _ in 0..STEPS_PER_SAMPLE {
                let k1 = speed(angle);
                let k2 = speed(angle + 0.5 * step * k1);
                let k3 = speed(angle + 0.5 * step * k2);
                let k4 = speed(angle + step * k3);
                angle += step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
            }
        }
        samples
    }
}

fn cases(random: u64, seed: u64) -> Result<Vec<Case>, Box<dyn Error>> {
    let mut cases = Vec::new();
    for (wheel_radius_mm, removal_rate_mm2_s, infeed_mm) in
        [(60.0, 3.0, 0.02), (60.0, 10.0, 0.05), (150.0, 3.0, 0.02), (150.0, 10.0, 0.05)]
    {
        let lobe = Lobe::reference(wheel_radius_mm, removal_rate_mm2_s, infeed_mm);
        let contour = lobe.contour().ok_or("the reference lobe is not regular")?;
        let path = ToolPath::for_wheel(&contour, wheel_radius_mm)?;
        cases.push(Case { name: format!("reference wheel {wheel_radius_mm} Q' {removal_rate_mm2_s}"), lobe, path });
    }
    for seed in seed..seed + random {
        let (lobe, path) = Lobe::random(seed);
        cases.push(Case { name: format!("random seed {seed}"), lobe, path });
    }
    Ok(cases)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, random, seed] = arguments.as_slice() else {
        return Err("turn_cases DIRECTORY RANDOM SEED".into());
    };
    let directory = Path::new(directory);
    fs::create_dir_all(directory)?;
    let cases = cases(random.parse()?, seed.parse()?)?;
    for (index, case) in cases.iter().enumerate() {
        case.write(directory, index)?;
    }
    println!("{}", cases.len());
    io::stdout().flush()?;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let (index, runs) = line.split_once(' ').ok_or("a line is CASE RUNS")?;
        let case = cases.get(index.parse::<usize>()?).ok_or("no such case")?;
        let mut nanoseconds = Vec::new();
        for _ in 0..runs.parse::<u32>()? {
            #[allow(clippy::disallowed_methods, reason = "measures the planner, which itself sees no clock")]
            let start = Instant::now();
            let turn = case.plan()?;
            nanoseconds.push(start.elapsed().as_nanos().to_string());
            std::hint::black_box(turn);
        }
        println!("{}", nanoseconds.join(" "));
        io::stdout().flush()?;
    }
    Ok(())
}
