// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Replay of the machine: it receives the recorded inputs at the same ticks, and must give the same outputs.

use super::difference::ReplayDifference;
use super::error::RerunError;
use super::keyframes;
use super::outputs::{Output, difference};
use super::recorded::RecordedInputs;
use camwright::math::snapshot::SnapshotCodec;
use camwright_bag::Bag;
use camwright_files::convert::keyframes::check;
use camwright_files::convert::setpoints::ChunkBuffer;
use camwright_machine_cycle::input_record::kind_name;
use camwright_machine_cycle::keyframes::FORM as KEYFRAME_FORM;
use camwright_machine_cycle::output_digest::{RangeDigest, chunk_digest};
use camwright_machine_cycle::replay::{MachineReplay, TickOutput};
use camwright_msgs::camwright_msgs::msg::{MachineInput, MachineKeyframe};
use std::collections::{HashMap, HashSet, VecDeque};

/// Ticks kept to be compared: topics are not written in the order of their ticks, but nearly.
const KEPT: usize = 8192;
/// Messages that may wait for a chunk that is not in sight yet; if it is still not, it will not come.
const WAITING: usize = 50_000;

/// The machine, run again.
#[derive(Debug)]
pub(super) struct MachineRun<'a> {
    bag: &'a Bag,
    recorded: &'a RecordedInputs,
    machine: MachineReplay,
    next: usize,
    /// The tick after which it began, and the last one.
    begun: u64,
    tick: u64,
    /// Keyframes that it has not come to.
    to_come: &'a [MachineKeyframe],
    kept: VecDeque<TickOutput>,
    /// Chunks that the machine takes, by their first ticks and digests.
    taken: HashSet<(u64, u64)>,
    /// Those that were sent and not taken yet, by their first tick, with their digests.
    chunks: HashMap<u64, Vec<(u64, ChunkBuffer)>>,
    waiting: VecDeque<(u64, Output)>,
    /// Digests of the replayed run, for the comparison with the recorded ones.
    pending_digests: VecDeque<RangeDigest>,
    pub(super) compared: u64,
    pub(super) keyframes: usize,
    pub(super) digests: Vec<RangeDigest>,
    pub(super) last_digest: u64,
}

impl<'a> MachineRun<'a> {
    /// The machine as it began, or as a keyframe says that it was.
    ///
    /// # Errors
    /// It cannot be made from what was recorded.
    pub(super) fn new(bag: &'a Bag, recorded: &'a RecordedInputs) -> Result<Self, RerunError> {
        let cannot = RerunError::Cannot;
        let (machine, begun) = match (&recorded.start, recorded.machine_inputs.first()) {
            (Some(head), _) => {
                let state = keyframes::state(bag, &recorded.topics, head)?;
                let machine = MachineReplay::from_keyframe(&recorded.machine, head, &state);
                (machine.map_err(|error| cannot(format!("the keyframe of tick {}: {error}", head.tick)))?, head.tick)
            }
            (None, Some(begin)) => (MachineReplay::new(&recorded.machine, begin).map_err(cannot)?, 0),
            (None, None) => return Err(cannot("nothing was recorded of the machine".into())),
        };
        let chunks = recorded.machine_inputs.iter().filter(|input| input.kind == MachineInput::CHUNK);
        let passed = recorded.keyframes.partition_point(|head| head.tick <= begun);
        Ok(Self {
            bag,
            recorded,
            machine,
            next: 0,
            begun,
            tick: begun,
            to_come: &recorded.keyframes[passed..],
            taken: chunks.map(|input| (input.number, input.digest)).collect(),
            kept: VecDeque::with_capacity(KEPT),
            chunks: HashMap::new(),
            waiting: VecDeque::new(),
            pending_digests: VecDeque::new(),
            compared: 0,
            keyframes: 0,
            digests: Vec::new(),
            last_digest: 0,
        })
    }

    /// Ticks executed so far.
    pub(super) fn ticks(&self) -> u64 {
        self.tick - self.begun
    }

    /// A chunk that was sent.
    pub(super) fn sent(&mut self, chunk: ChunkBuffer) {
        let digest = chunk_digest(&chunk);
        if self.taken.contains(&(chunk.first_tick, digest)) {
            self.chunks.entry(chunk.first_tick).or_default().push((digest, chunk));
        }
    }

    /// Output of a recorded tick: compared as soon as the chunks that the machine needs are available.
    ///
    /// # Errors
    /// The first difference.
    pub(super) fn compare_output(&mut self, tick: u64, output: Output) -> Result<(), Box<ReplayDifference>> {
        if tick <= self.begun || tick > self.recorded.last_tick {
            return Ok(());
        }
        self.waiting.push_back((tick, output));
        let is_late = self.waiting.len() > WAITING;
        self.work(is_late)
    }

    /// The bag is at its end: the machine runs to its last tick.
    ///
    /// # Errors
    /// The first difference.
    pub(super) fn finish(&mut self) -> Result<(), Box<ReplayDifference>> {
        self.work(true)?;
        self.run_to(self.recorded.last_tick, true)?;
        // Inputs of after the last tick that the recorder received changed nothing that it knows.
        Ok(())
    }

    fn work(&mut self, is_all_in_sight: bool) -> Result<(), Box<ReplayDifference>> {
        while let Some((tick, _)) = self.waiting.front() {
            let tick = *tick;
            if !self.run_to(tick, is_all_in_sight)? {
                return Ok(());
            }
            let Some((_, output)) = self.waiting.pop_front() else { return Ok(()) };
            let of_tick = self.kept.front().and_then(|first| tick.checked_sub(first.report.tick));
            let ticked = of_tick.and_then(|place| self.kept.get(usize::try_from(place).ok()?));
            // What comes so late that its tick is not kept any more is in the digests.
            let Some(ticked) = ticked else { continue };
            self.compared += 1;
            if let Some(found) = difference(&output, ticked, &self.recorded.machine, self.recorded.clock) {
                return Err(found.into());
            }
        }
        Ok(())
    }

    /// Runs up to a tick; false: a chunk is not in sight yet without which it cannot.
    fn run_to(&mut self, tick: u64, is_all_in_sight: bool) -> Result<bool, Box<ReplayDifference>> {
        while self.tick < tick {
            if !self.apply_inputs(is_all_in_sight)? {
                return Ok(false);
            }
            let Some(ticked) = self.machine.tick() else {
                return Err(ReplayDifference::texts(self.tick + 1, "the machine", "a tick", "none").into());
            };
            self.tick = ticked.report.tick;
            if self.kept.len() == KEPT {
                self.kept.pop_front();
            }
            self.pending_digests.extend(ticked.digests.into_iter().flatten());
            self.kept.push_back(ticked);
            self.compare_state()?;
        }
        Ok(true)
    }

    /// The machine's state, against the keyframe of the same tick.
    fn compare_state(&mut self) -> Result<(), Box<ReplayDifference>> {
        let Some((head, rest)) = self.to_come.split_first().filter(|(head, _)| head.tick <= self.tick) else {
            return Ok(());
        };
        self.to_come = rest;
        // A state of another form cannot be compared; a repeated one has been compared.
        if head.form != KEYFRAME_FORM || head.tick != self.tick {
            return Ok(());
        }
        let field = "state of the machine";
        let failed = |reason: String| Box::new(ReplayDifference::texts(head.tick, field, "a keyframe", reason));
        let state = self.machine.state().map_err(failed)?;
        if check(head, &state) != head.check {
            let recorded = keyframes::state(self.bag, &self.recorded.topics, head);
            let recorded = recorded.map_err(|error| failed(error.to_string()))?;
            let place = self.machine.follow(&mut SnapshotCodec::comparing(&recorded)).err();
            return Err(failed(place.unwrap_or_else(|| "digest or inputs of it are others".to_owned())));
        }
        self.keyframes += 1;
        Ok(())
    }

    /// Gives the machine what it was given before the next tick.
    fn apply_inputs(&mut self, is_all_in_sight: bool) -> Result<bool, Box<ReplayDifference>> {
        let recorded = self.recorded;
        while let Some(input) = recorded.machine_inputs.get(self.next).filter(|input| input.tick <= self.tick) {
            if input.kind == MachineInput::DIGEST {
                self.next += 1;
                self.compare_digest(input)?;
                continue;
            }
            let is_chunk = input.kind == MachineInput::CHUNK;
            let is_here = |sent: &Vec<(u64, ChunkBuffer)>| sent.iter().any(|(digest, _)| *digest == input.digest);
            if is_chunk && !is_all_in_sight && !self.chunks.get(&input.number).is_some_and(is_here) {
                return Ok(false);
            }
            self.next += 1;
            let chunks = &mut self.chunks;
            let outcome = self.machine.apply(input, |first, digest| chunk(chunks, first, digest));
            outcome.map_err(|reason| ReplayDifference::texts(input.tick, kind_name(input.kind), "an input", reason))?;
        }
        Ok(true)
    }

    /// Compares a recorded digest with that of the same tick.
    fn compare_digest(&mut self, input: &MachineInput) -> Result<(), Box<ReplayDifference>> {
        let field = "digest of all that the machine put out";
        let text = |ticks: u64, digest: u64| format!("{digest:016x} after {ticks} ticks of a job");
        let Some(pending) = self.pending_digests.pop_front() else {
            return Err(ReplayDifference::texts(input.tick, field, text(input.number, input.digest), "none").into());
        };
        if (pending.job_ticks, pending.digest) != (input.number, input.digest) {
            let (old, new) = (text(input.number, input.digest), text(pending.job_ticks, pending.digest));
            return Err(ReplayDifference::texts(pending.tick, field, old, new).into());
        }
        self.last_digest = pending.digest;
        self.digests.push(pending);
        Ok(())
    }
}

/// The chunk that the machine took, out of those that were sent.
fn chunk(chunks: &mut HashMap<u64, Vec<(u64, ChunkBuffer)>>, first: u64, digest: u64) -> Result<ChunkBuffer, String> {
    let missing = || format!("the chunk that begins at tick {first} is not on machine/setpoints");
    let sent = chunks.get_mut(&first).ok_or_else(missing)?;
    let at = sent.iter().position(|(of_sent, _)| *of_sent == digest);
    let at = at.ok_or_else(|| format!("the chunk that begins at tick {first} is not the one that the machine took"))?;
    let (_, chunk) = sent.remove(at);
    if sent.is_empty() {
        chunks.remove(&first);
    }
    Ok(chunk)
}
