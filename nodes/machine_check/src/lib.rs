// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Check of a machine against its contract (`nodes/MACHINE_CONTRACT.md`), clause by clause.
//!
//! It listens first, and judges what it heard once it has received it: a judge is a function of messages. What it compares it computes
//! itself, in integers and by a polynomial of its own, and not by what camwright's own nodes and the simulated machine do it with.

mod alarms;
mod feedback;
mod identity;
mod motion;
mod observed;
mod report;
mod time;

use camwright_authority::{HeldCommand, TakeError, TakeOptions};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::running::NodeError;
use camwright_ros::{Node, NodeOptions, RosArgs, Shutdown};
use observed::{DescriptionFacts, Observed, Observer};
pub use report::{ClauseReport, ClauseVerdict};
use std::time::Duration;
use thiserror::Error;

/// Maximum time until endpoints and names of nodes are known after the first message.
const DISCOVERY: Duration = Duration::from_secs(2);
/// Maximum delay of messages that belong to the last tick.
const AFTERMATH: Duration = Duration::from_millis(300);
/// Maximum time of a reset.
const ANSWER: Duration = Duration::from_secs(10);

/// Receiver of progress texts.
pub type ProgressSink<'a> = &'a dyn Fn(&str);

/// The axis that may be moved, and by how much (m or rad).
#[derive(Debug, Clone, PartialEq)]
pub struct Moving {
    pub joint: String,
    /// From where it rests.
    pub distance: f64,
}

/// Settings of a check.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Listening time.
    pub listen: Duration,
    /// Maximum time until the machine sends a message.
    pub patience: Duration,
    /// Permitted motion; `None`: nothing moves.
    pub moving: Option<Moving>,
}

/// Why nothing was judged.
#[derive(Debug, Error)]
pub enum CheckError {
    /// There is no machine.
    #[error("no machine found within {0} s; check ROS_DOMAIN_ID and --namespace")]
    Silent(f64),
    /// The machine is in use, or cannot be moved as was asked.
    #[error("nothing is moved: {0}")]
    Refused(String),
    #[error(transparent)]
    Node(#[from] NodeError),
}

/// Result of a check.
#[derive(Debug)]
pub struct Checked {
    pub report: ClauseReport,
    /// Interrupted by the user.
    pub interrupted: bool,
}

/// Checks the machine in the domain.
///
/// # Errors
/// No machine sends messages, it is not free to be moved, DDS cannot start.
pub fn check(
    args: &RosArgs,
    settings: &Settings,
    shutdown: &Shutdown,
    report_progress: ProgressSink<'_>,
) -> Result<Checked, CheckError> {
    let node = Node::new(NodeOptions::new("check_machine", args)).map_err(NodeError::from)?;
    let ears = Observer::default();
    let subscriptions = ears.open(&node).map_err(NodeError::from)?;
    let spin = node.spin_in_thread().map_err(NodeError::from)?;
    let outcome = listen(&node, args, &ears, settings, shutdown, report_progress);
    drop(spin);
    drop(subscriptions);
    node.shutdown();
    outcome
}

fn listen(
    node: &Node,
    args: &RosArgs,
    ears: &Observer,
    settings: &Settings,
    shutdown: &Shutdown,
    report_progress: ProgressSink<'_>,
) -> Result<Checked, CheckError> {
    report_progress("waiting for a machine");
    let is_there = |observed: &Observed| observed.description.is_some() && observed.last().is_some();
    if ears.wait(settings.patience, |observed| is_there(observed).then_some(())).is_none()
        && ears.read(|observed| observed.description.is_none() && observed.last().is_none())
    {
        return Err(CheckError::Silent(settings.patience.as_secs_f64()));
    }
    let mut report = ClauseReport::default();
    let Some(description) = ears.read(|observed| observed.description.clone()) else {
        ears.read(|observed| identity::judge(observed, &mut report));
        return Ok(Checked { report, interrupted: false });
    };
    report.machine.clone_from(&description.name);
    let facts = DescriptionFacts::from_description(&description);
    let target = match &settings.moving {
        None => None,
        Some(moving) => {
            // The texts of alarms come on a topic of their own, which may be later than the stream.
            let _texts = ears.wait(DISCOVERY, |observed| observed.alarms_agree().then_some(()));
            let free = motion::obstacle(ears).map_or(Ok(()), Err);
            let target =
                free.and_then(|()| ears.read(|observed| motion::target(&description, &facts, observed, moving)));
            Some(target.map_err(CheckError::Refused)?)
        }
    };
    report_progress(&format!("listening to {} for {} s", description.name, settings.listen.as_secs_f64()));
    let mut interrupted = shutdown.wait_timeout(settings.listen.max(DISCOVERY));
    identity::endpoints(node, &mut report);
    if !interrupted {
        let command = take_command(node, &mut report)?;
        // Another client may have taken command meanwhile.
        match (target, motion::obstacle(ears)) {
            (Some(_), Some(obstacle)) => return Err(CheckError::Refused(obstacle)),
            (Some(target), None) => {
                interrupted = motion::run(
                    (node, args, shutdown),
                    (ears, &facts, &description),
                    target,
                    &mut report,
                    report_progress,
                );
            }
            (None, obstacle) => reset(node, ears, obstacle, &mut report),
        }
        drop(command);
    }
    judge(node, ears, &facts, &mut report);
    Ok(Checked { report, interrupted })
}

/// M16: command is taken, and shared with the second sender that a travel is tried with.
fn take_command(node: &Node, report: &mut ClauseReport) -> Result<Option<HeldCommand>, CheckError> {
    let options = TakeOptions { patience: ANSWER, ..TakeOptions::new("camwright check-machine").shared() };
    match HeldCommand::acquire(node, &options) {
        Ok(command) => {
            report.kept(16, "machine/take_command gives command to who asks first");
            Ok(Some(command))
        }
        Err(TakeError::Refused(reason)) => Err(CheckError::Refused(reason)),
        Err(error) => {
            report.broken(16, format!("command cannot be taken: {error}"));
            Ok(None)
        }
    }
}

/// Judges everything that was received.
fn judge(node: &Node, ears: &Observer, facts: &DescriptionFacts, report: &mut ClauseReport) {
    // Topics overtake each other: ticks that the other topics have not reported yet are ignored.
    let streams = ears.read(|observed| observed.streams.len());
    let _no_more = ears.wait(AFTERMATH, |_| None::<()>);
    let publishes_clock = node.publisher_count("/clock").is_ok_and(|count| count > 0);
    ears.read(|observed| {
        let observed = observed.until(streams);
        identity::judge(&observed, report);
        time::judge(&observed, facts, publishes_clock, report);
        feedback::judge(&observed, facts, report);
        alarms::judge(&observed, report);
    });
}

/// M30: a reset of a machine that has nothing to reset succeeds, and starts nothing.
fn reset(node: &Node, ears: &Observer, obstacle: Option<String>, report: &mut ClauseReport) {
    if let Some(obstacle) = obstacle {
        return report.not_seen(30, format!("machine/reset was not tried: {obstacle}"));
    }
    let there = |observed: &Observed| observed.last().map(|news| news.setpoint_counts.clone());
    let answer = node.client::<Trigger>("machine/reset").and_then(|client| {
        client.wait_for_service(ANSWER)?;
        let (before, moved) = ears.read(|observed| {
            let moved = feedback::moves_at_standstill(&observed.streams).next().map(|(_, other)| other.tick);
            (there(observed), moved)
        });
        Ok((before, moved, client.call(&TriggerRequest::default(), ANSWER)?))
    });
    let (before, moved) = match answer {
        Err(error) => return report.broken(30, error.to_string()),
        Ok((_, _, answer)) if !answer.success => {
            return report.broken(30, format!("machine/reset at rest, with no alarm, is refused: {}", answer.message));
        }
        Ok((before, moved, _)) => (before, moved),
    };
    if let Some(tick) = moved {
        let otherwise =
            format!("the effect of a reset cannot be checked: setpoints moved at standstill without one (tick {tick})");
        return report.not_seen(30, otherwise);
    }
    let observed_before = ears.read(|observed| observed.streams.len());
    let _some_more = ears.wait(ANSWER, |observed| (observed.streams.len() > observed_before + 5).then_some(()));
    let is_still = |news: &MachineStream| news.motion == MachineStream::MOTION_STANDSTILL;
    if ears.read(there) == before && ears.read(|observed| observed.last().is_some_and(is_still)) {
        report.kept(30, "a reset at rest succeeds, and nothing moves");
    } else {
        report.broken(30, format!("after a reset at rest setpoints go from {before:?} to {:?}", ears.read(there)));
    }
}
