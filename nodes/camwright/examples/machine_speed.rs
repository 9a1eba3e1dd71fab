//! Simulation speed of the machine: `cargo run --release -p camwright_nodes --example machine_speed [JOB [RUNS]]`.
//!
//! Simulates a job (`four_lobe_camshaft`) on one core, interpolator and machine in one loop, as the nodes step them; prints machine
//! seconds per second of the wall clock: on the machine as it is, and without what leaves errors on the part.
#![allow(clippy::print_stdout, reason = "a command")]

use camwright::machine::description::Effect;
use camwright_planning::{prepare, simulate_job};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let job = words.next().unwrap_or_else(|| "four_lobe_camshaft".to_owned());
    let runs: u32 = words.next().map_or(Ok(3), |word| word.parse())?;
    let prepared = prepare(&job, &[], None)?;
    let machine = &prepared.machine;
    let steps = f64::from(machine.servo_steps_per_tick) / machine.cycle_time_s();
    println!("{job}: {steps} servo steps a second, best of {runs} runs on one core");
    for without in [&[][..], &Effect::ALL[..]] {
        let mut best_s = f64::INFINITY;
        let mut machine_s = 0.0;
        for _ in 0..runs {
            let start = Instant::now();
            let (simulated, _) = simulate_job(&prepared, without, |_, _| {})?;
            best_s = best_s.min(start.elapsed().as_secs_f64());
            let ticks = u32::try_from(simulated.last_tick - simulated.first_tick + 1)?;
            machine_s = f64::from(ticks) * machine.cycle_time_s();
        }
        let name = if without.is_empty() { "as it is" } else { "ideal" };
        println!(
            "machine {name:<9} {machine_s:.2} s in {best_s:.3} s: {:.0} times as fast as time",
            machine_s / best_s
        );
    }
    Ok(())
}
