// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright replay BAG --against`: computes a run again from its inputs as they were applied, and says whether it is the same to the bit.
//!
//! ```text
//! axis_interpolator/inputs, plans ─► Interpolator ─► chunks ── the same as on machine/setpoints?
//! machine/inputs, machine/setpoints ─► machine ─► ticks ────── the same as on joint_states, machine/stream, io, gauge, and in the digests?
//! ```
//! Interpolator and machine are replayed separately, each from its own recorded inputs, so a difference is reported at its source. Real
//! drives cannot be computed again: of such a run only the interpolator is replayed.

mod cuts;
mod difference;
mod digests;
mod error;
mod keyframes;
mod machine;
mod motion;
mod outputs;
mod recorded;
mod topics;
mod window;

pub use difference::{DifferingValues, ReplayDifference};
pub use error::RerunError;
pub use window::Window;

use camwright_bag::Bag;
use camwright_files::convert::setpoints::chunk_from_trajectory;
use camwright_files::convert::time::ns_from_time;
use camwright_machine_cycle::input_record::{VERSION, version_of};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use cuts::CutComparison;
use digests::DigestComparison;
use machine::MachineRun;
use motion::InterpolatorReplay;
use outputs::Output;
use recorded::RecordedInputs;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;
use topics::read;

/// Result of recomputing a run.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayVerdict {
    /// Bus to the real drives of the machine, which are not recomputed; `None`: they were simulated.
    pub drives: Option<String>,
    /// Version of the program that recorded it, if the bag says so.
    pub recorded_by: Option<String>,
    /// The tick of the keyframe that it began from; 0: from the beginning.
    pub begun: u64,
    /// Inputs that are not as they were recorded, by their ticks.
    pub changed: Vec<(u64, String)>,
    /// The first difference, in the order of ticks; of interpolator and machine at most one each.
    pub differences: Vec<ReplayDifference>,
    /// Ticks of the machine that were computed.
    pub ticks: u64,
    /// Setpoints that were computed and compared.
    pub setpoints: u64,
    /// Motions that they are of.
    pub motions: u64,
    /// Messages of the machine that were compared with its ticks.
    pub compared: u64,
    /// Keyframes that the machine's state was compared with.
    pub keyframes: usize,
    /// Digests that were compared, and the last of them.
    pub digests: (usize, u64),
    /// Messages that the recorder has lost.
    pub lost: u64,
    /// Time of the machine (s), and the time that it took to compute it (s).
    pub seconds: (f64, f64),
}

impl ReplayVerdict {
    /// The run is the same.
    #[must_use]
    pub fn is_identical(&self) -> bool {
        self.changed.is_empty() && self.differences.is_empty()
    }

    /// Speed of the computation relative to real time.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.seconds.0 / self.seconds.1.max(1e-9)
    }

    /// The verdict in lines for people, what differs first.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut lines: Vec<String> = Vec::new();
        if let Some((tick, input)) = self.changed.first() {
            let more = match self.changed.len() - 1 {
                0 => String::new(),
                more => format!(" (and {more} more)"),
            };
            lines.push(format!(
                "differs: tick {tick}: {input}, changed since it was recorded: its check sum does not fit{more}"
            ));
        }
        for difference in &self.differences {
            lines.push(format!("differs: {difference}"));
        }
        let (done, rate) = (if lines.is_empty() { "identical" } else { "before that" }, self.speed());
        let (ticks, setpoints, motions) = (self.ticks, self.setpoints, self.motions);
        let (digests, last) = self.digests;
        let from = if self.begun > 0 { format!(" after tick {}", self.begun) } else { String::new() };
        let last = if digests > 0 { format!(", last digest {last:016x}") } else { String::new() };
        if let Some(drives) = &self.drives {
            let seconds = self.seconds.0;
            lines.push(format!("{done}: {setpoints} setpoints of {motions} motions ({seconds:.3} s of machine time)"));
            lines.push(format!("the machine is real ({drives}): only the interpolator is recomputed"));
        } else {
            lines.push(format!("{done}: {ticks} ticks{from} ({:.3} s of machine time)", self.seconds.0));
            lines.push(format!("compared: {setpoints} setpoints of {motions} motions, {} messages", self.compared));
            lines.push(format!("          {} keyframes, {digests} digests{last}", self.keyframes));
        }
        lines.push(format!("computed in {:.3} s, {rate:.1} times as fast", self.seconds.1));
        if let Some(recorded_by) = self.recorded_by.as_ref().filter(|version| *version != VERSION) {
            lines.push(format!("recorded by camwright {recorded_by}, computed by camwright {VERSION}"));
        }
        if self.lost > 0 {
            lines.push(format!("the recorder lost {} messages, none of them an input", self.lost));
        }
        lines.join("\n")
    }
}

/// Comparison with another run.
#[derive(Debug, Clone, PartialEq)]
enum OtherRun {
    /// Of simulated machines: everything, by digests.
    Digests(DigestComparison),
    /// One of the machines at least is real.
    Cuts(CutComparison),
}

impl OtherRun {
    fn compare(one: &Path, other: &Path) -> Result<Self, RerunError> {
        let [one, other] = [one, other].map(|path| {
            let bag = Bag::open(path)?;
            let recorded = RecordedInputs::from_bag(&bag, Window::default())?;
            Ok::<_, RerunError>((bag, recorded))
        });
        let [(bag, recorded), (other_bag, other_recorded)] = [one?, other?];
        if recorded.drives().is_none() && other_recorded.drives().is_none() {
            return Ok(Self::Digests(digests::compare(&recorded.machine_inputs, &other_recorded.machine_inputs)));
        }
        let cuts = |bag: &Bag, recorded: &RecordedInputs| {
            let mut interpolator = InterpolatorReplay::new(recorded);
            // What comes after a difference is missing in the cuts.
            let _differences = compare(bag, recorded, &mut interpolator, None)?;
            Ok::<_, RerunError>(interpolator.jobs)
        };
        let (ours, theirs) = (cuts(&bag, &recorded)?, cuts(&other_bag, &other_recorded)?);
        Ok(Self::Cuts(CutComparison::new(&ours, &theirs, &recorded.machine)))
    }

    fn is_same(&self) -> bool {
        match self {
            Self::Digests(compared) => compared.is_same(),
            Self::Cuts(compared) => compared.is_same(),
        }
    }

    fn to_text(&self) -> String {
        match self {
            Self::Digests(compared) => compared.to_text(),
            Self::Cuts(compared) => compared.to_text(),
        }
    }
}

/// Result of `camwright replay BAG --against [OTHER]`.
#[derive(Debug, Clone, PartialEq)]
pub struct RunComparison {
    pub verdict: ReplayVerdict,
    /// Comparison with the other run, if there is one.
    other: Option<OtherRun>,
}

impl RunComparison {
    /// The computed run is the recorded one, and the other run is the same.
    #[must_use]
    pub fn is_same(&self) -> bool {
        self.verdict.is_identical() && self.other.as_ref().is_none_or(OtherRun::is_same)
    }

    /// The verdict in lines for people, that of the other run first.
    #[must_use]
    pub fn to_text(&self) -> String {
        let other = self.other.as_ref().map_or_else(String::new, |other| other.to_text() + "\n");
        other + &self.verdict.to_text()
    }

    /// The verdict for scripts.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let ReplayVerdict { ticks, setpoints, motions, compared, keyframes, lost, .. } = self.verdict;
        let differences = self.verdict.differences.iter();
        let changed = self.verdict.changed.iter().map(|(tick, input)| json!({ "tick": tick, "input": input }));
        json!({
            "is_same": self.is_same(),
            "is_identical": self.verdict.is_identical(),
            "differences": differences.map(|found| json!({ "tick": found.tick, "text": found.to_string() })).collect::<Vec<_>>(),
            "changed_inputs": changed.collect::<Vec<_>>(),
            "drives": self.verdict.drives,
            "from_tick": self.verdict.begun,
            "ticks": ticks,
            "setpoints": setpoints,
            "motions": motions,
            "messages": compared,
            "keyframes": keyframes,
            "digests": self.verdict.digests.0,
            "last_digest": format!("{:016x}", self.verdict.digests.1),
            "messages_lost": lost,
            "machine_time_s": self.verdict.seconds.0,
            "took_s": self.verdict.seconds.1,
            "recorded_by": self.verdict.recorded_by,
            "computed_by": VERSION,
            "other_run": self.other.as_ref().map(|other| json!({ "is_same": other.is_same(), "text": other.to_text() })),
        })
    }
}

/// Computes the run of a bag again over a window of its ticks, and compares it with the recorded and with another run.
///
/// # Errors
/// See [`within`].
pub fn against(bag: &Path, other: Option<&Path>, window: Window) -> Result<RunComparison, RerunError> {
    let verdict = within(bag, window)?;
    Ok(RunComparison { verdict, other: other.map(|other| OtherRun::compare(bag, other)).transpose()? })
}

/// Computes the run of a bag again.
///
/// # Errors
/// The bag cannot be read, or does not contain the inputs of a run.
pub fn rerun(path: &Path) -> Result<ReplayVerdict, RerunError> {
    within(path, Window::default())
}

/// Computes a window of the run of a bag again.
///
/// # Errors
/// See [`rerun`]; or no keyframe exists before the window.
pub fn within(path: &Path, window: Window) -> Result<ReplayVerdict, RerunError> {
    let begun = Instant::now();
    let bag = Bag::open(path)?;
    let recorded = RecordedInputs::from_bag(&bag, window)?;
    let mut interpolator = InterpolatorReplay::new(&recorded);
    let drives = recorded.drives();
    let mut machine = if drives.is_none() { Some(MachineRun::new(&bag, &recorded)?) } else { None };
    let differences = compare(&bag, &recorded, &mut interpolator, machine.as_mut())?;
    let lost = bag.custom_data().get("camwright.lost_total").and_then(|text| text.parse().ok());
    let cycle_s = recorded.machine.cycle_time_s();
    let ticks = machine.as_ref().map_or(0, MachineRun::ticks);
    let computed = if drives.is_none() { ticks } else { interpolator.setpoints };
    let seconds = (computed as f64 * cycle_s, begun.elapsed().as_secs_f64());
    Ok(ReplayVerdict {
        drives,
        recorded_by: recorded.machine_inputs.first().and_then(version_of),
        begun: recorded.start.as_ref().map_or(0, |start| start.tick),
        changed: recorded.changed(),
        differences,
        ticks,
        setpoints: interpolator.setpoints,
        motions: interpolator.motions,
        compared: machine.as_ref().map_or(0, |machine| machine.compared),
        keyframes: machine.as_ref().map_or(0, |machine| machine.keyframes),
        digests: machine.as_ref().map_or((0, 0), |machine| (machine.digests.len(), machine.last_digest)),
        lost: lost.unwrap_or(0),
        seconds,
    })
}

/// Goes through the bag once; interpolator and machine, if it was simulated, each up to where they first differ.
fn compare(
    bag: &Bag,
    recorded: &RecordedInputs,
    interpolator: &mut InterpolatorReplay<'_>,
    mut machine: Option<&mut MachineRun<'_>>,
) -> Result<Vec<ReplayDifference>, RerunError> {
    let topics = &recorded.topics;
    let (mut of_interpolator, mut of_machine): (Option<ReplayDifference>, Option<ReplayDifference>) = (None, None);
    let has_inputs = topics.interpolator_inputs.is_some();
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message()? {
        let at = Some(message.topic);
        if at == topics.setpoints {
            let chunk: JointTrajectory = read(bag, &message)?;
            let first_tick = recorded.clock.nearest_tick(ns_from_time(&chunk.header.stamp));
            let is_asked_for = first_tick.is_none_or(|tick| tick <= recorded.last_tick);
            if of_interpolator.is_none() && has_inputs && is_asked_for {
                of_interpolator = interpolator.chunk(&chunk).err().map(|found| *found);
            }
            // What is no chunk the machine has refused; that is among its inputs.
            if let (Some(machine), Ok(chunk)) =
                (machine.as_mut(), chunk_from_trajectory(&chunk, &recorded.machine, recorded.clock))
            {
                machine.sent(chunk);
            }
            continue;
        }
        let Some(machine) = machine.as_mut().filter(|_| of_machine.is_none()) else { continue };
        let output = if at == topics.joint_states {
            let joints: JointState = read(bag, &message)?;
            recorded.clock.nearest_tick(ns_from_time(&joints.header.stamp)).map(|tick| (tick, Output::Joints(joints)))
        } else if at == topics.stream {
            let stream: MachineStream = read(bag, &message)?;
            Some((stream.tick, Output::Stream(Box::new(stream))))
        } else if at == topics.io {
            let io: camwright_msgs::camwright_msgs::msg::MachineIo = read(bag, &message)?;
            Some((io.tick, Output::Io(Box::new(io))))
        } else if at == topics.gauge {
            let gauge: camwright_msgs::camwright_msgs::msg::GaugeReading = read(bag, &message)?;
            Some((gauge.tick, Output::Gauge(gauge)))
        } else if at == topics.alarms {
            let alarms: camwright_msgs::camwright_msgs::msg::MachineAlarms = read(bag, &message)?;
            Some((alarms.tick, Output::Alarms(alarms)))
        } else {
            None
        };
        if let Some((tick, output)) = output {
            of_machine = machine.compare_output(tick, output).err().map(|found| *found);
        }
    }
    if let Some(machine) = machine.filter(|_| of_machine.is_none()) {
        of_machine = machine.finish().err().map(|found| *found);
    }
    let mut differences: Vec<ReplayDifference> = of_interpolator.into_iter().chain(of_machine).collect();
    differences.sort_by_key(|difference| difference.tick);
    Ok(differences)
}
