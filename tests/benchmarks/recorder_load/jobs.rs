// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cell at work for the campaign: jobs one after the other.

use super::cell;
use super::support::PATIENCE;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{GoalStatus, Node};
use std::path::Path;
use std::time::{Duration, Instant};

/// A job with one lobe, which takes a minute or so.
const JOB: &str = "brake_cam";
/// The alarms that stop a job on a computer that is too busy for the wall clock's pace: no setpoint in time, a command that came late. What
/// was recorded is to be whole all the same.
const LATE: [u16; 2] = [80, 81];
/// Maximum time of a job.
const LONGEST: Duration = Duration::from_secs(1200);

/// Jobs one after the other for so long.
pub fn campaign(bag: &Path, time: Duration) -> Vec<String> {
    cell::record(bag, |node| run_jobs(node, time))
}

/// Runs a job to its end; whether the computer was fast enough for it.
fn run_job(node: &Node) -> Result<bool, String> {
    let client = node.action_client::<RunJob>("job_planner/run_job").map_err(|error| error.to_string())?;
    client.wait_for_server(PATIENCE).map_err(|error| error.to_string())?;
    let goal = RunJobGoal { job: JOB.to_owned(), ..RunJobGoal::default() };
    let sent = client.send_goal(goal, drop, PATIENCE).map_err(|error| error.to_string())?;
    if !sent.accepted() {
        return Err(format!("{JOB} is refused"));
    }
    let (status, result) = sent.result(LONGEST).map_err(|error| error.to_string())?;
    match (status, result.alarm) {
        (GoalStatus::Succeeded, _) => Ok(true),
        (_, alarm) if LATE.contains(&alarm) => reset(node).map(|()| false),
        _ => Err(result.message),
    }
}

/// Resets the machine, once it stands.
fn reset(node: &Node) -> Result<(), String> {
    let client = node.client::<Trigger>("machine/reset").map_err(|error| error.to_string())?;
    client.wait_for_service(PATIENCE).map_err(|error| error.to_string())?;
    let deadline = Instant::now() + PATIENCE;
    while !client.call(&TriggerRequest::default(), PATIENCE).map_err(|error| error.to_string())?.success {
        if Instant::now() > deadline {
            return Err("the machine cannot be reset".into());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}

/// Runs jobs until the time is over, the last one to its end.
fn run_jobs(node: &Node, time: Duration) -> Vec<String> {
    let (begun, mut whole, mut stopped) = (Instant::now(), 0, 0);
    while begun.elapsed() < time {
        match run_job(node) {
            Ok(true) => whole += 1,
            Ok(false) => stopped += 1,
            Err(error) => return vec![format!("job {}: {error}", whole + stopped + 1)],
        }
        eprintln!("{} jobs, {:.0} of {:.0} s", whole + stopped, begun.elapsed().as_secs_f64(), time.as_secs_f64());
    }
    let seconds = begun.elapsed().as_secs_f64();
    println!(
        "{whole} jobs {JOB} in {seconds:.0} s, and {stopped} that an alarm of {LATE:?} stopped (the computer was late)"
    );
    Vec::new()
}
