// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Result of a check: clause by clause kept, broken or not seen.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt;

/// Maximum number of reported pieces of evidence per clause; the rest is counted.
const MAX_EVIDENCE: usize = 4;

/// A clause: its number, what it is about, and what to do where it was not seen.
type Clause = (u8, &'static str, &'static str);

/// The clauses of the contract.
const CLAUSES: &[Clause] = &[
    (1, "description", "publish machine/description, latched"),
    (2, "ticks and stamps", "listen while the machine ticks"),
    (3, "how often machine/stream comes", "listen longer"),
    (4, "credit", "listen while the machine ticks"),
    (5, "counts of setpoints and encoders", "publish joint_states with the axes' joints, with the stamps of ticks"),
    (6, "edges of inputs", "let an axis pass a switch meanwhile: --move an axis over one"),
    (7, "joint_states", "publish joint_states"),
    (8, "state of motion", "listen while the axes rest; --move to see it change"),
    (9, "types and quality of service", "listen longer"),
    (10, "chunks are followed", "--move an axis"),
    (11, "a chunk replaces the setpoints before it", "--move an axis"),
    (12, "silence is a stop", "--move an axis of a machine at pace realtime"),
    (13, "chunks that are refused", "--move an axis"),
    (14, "who has command", "--move an axis"),
    (16, "command has to be taken", "listen to the end"),
    (20, "order of commands", "--move an axis, on a machine with an input"),
    (
        21,
        "home and inputs",
        "--move an axis while an input of machine/io is closed; SET_HOME and LOSE_HOME are seen when camwright homes",
    ),
    (22, "missing equipment", "command it by hand: no test does, because a machine that has it would start it"),
    (23, "change of the wheel", "command it by hand: no test does, because it moves the changer"),
    (30, "alarms and their reset", "let an alarm happen: --move does"),
    (31, "a stop is on the path", "--move an axis of a machine at pace realtime"),
    (32, "limits the machine watches itself", "move an axis past its limits, by hand and with care: no test does"),
    (33, "machine/estop", "--move an axis, for it takes the power off"),
    (40, "pace realtime", "run the machine at pace realtime"),
    (41, "pace fast", "run a simulated machine at pace fast"),
];

#[derive(Debug, Clone, Default)]
struct ClauseRecord {
    kept: Vec<String>,
    broken: Vec<String>,
    /// Number of further violations of the same kind.
    more: usize,
    why_unseen: Option<String>,
}

/// Verdict on a clause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClauseVerdict {
    /// It was looked at, and kept.
    Kept,
    /// It was not kept.
    Broken,
    /// Nothing was to be seen of it.
    NotSeen,
}

impl ClauseVerdict {
    const fn word(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Broken => "BROKEN",
            Self::NotSeen => "not seen",
        }
    }
}

/// Result of a check.
#[derive(Debug, Clone, Default)]
pub struct ClauseReport {
    /// Name of the machine.
    pub machine: String,
    judged: BTreeMap<u8, ClauseRecord>,
}

impl ClauseReport {
    /// A clause was looked at and kept: what was seen.
    pub(super) fn kept(&mut self, clause: u8, seen: impl Into<String>) {
        self.judged.entry(clause).or_default().kept.push(seen.into());
    }

    /// A clause was broken: what, how much, how much is allowed, at which tick.
    pub(super) fn broken(&mut self, clause: u8, evidence: impl Into<String>) {
        let judged = self.judged.entry(clause).or_default();
        if judged.broken.len() < MAX_EVIDENCE {
            judged.broken.push(evidence.into());
        } else {
            judged.more += 1;
        }
    }

    /// A clause could not be looked at, and why.
    pub(super) fn not_seen(&mut self, clause: u8, why: impl Into<String>) {
        self.judged.entry(clause).or_default().why_unseen.get_or_insert(why.into());
    }

    /// Kept where nothing was found against it since `before` pieces of evidence were counted.
    pub(super) fn kept_unless_broken(&mut self, clause: u8, before: usize, seen: impl Into<String>) {
        if self.evidence(clause) == before {
            self.kept(clause, seen);
        }
    }

    /// Number of violations of a clause so far.
    pub(super) fn evidence(&self, clause: u8) -> usize {
        self.judged.get(&clause).map_or(0, |judged| judged.broken.len() + judged.more)
    }

    /// Verdict on a clause.
    #[must_use]
    pub fn verdict(&self, clause: u8) -> ClauseVerdict {
        match self.judged.get(&clause) {
            Some(judged) if !judged.broken.is_empty() => ClauseVerdict::Broken,
            Some(judged) if !judged.kept.is_empty() => ClauseVerdict::Kept,
            _ => ClauseVerdict::NotSeen,
        }
    }

    /// Numbers of the clauses that were found so.
    #[must_use]
    pub fn clauses(&self, verdict: ClauseVerdict) -> Vec<u8> {
        CLAUSES.iter().map(|(number, ..)| *number).filter(|number| self.verdict(*number) == verdict).collect()
    }

    fn lines(&self, (number, _, how): &Clause) -> Vec<String> {
        let judged = self.judged.get(number).cloned().unwrap_or_default();
        match self.verdict(*number) {
            ClauseVerdict::Broken if judged.more > 0 => {
                judged.broken.into_iter().chain([format!("and {} times more", judged.more)]).collect()
            }
            ClauseVerdict::Broken => judged.broken,
            ClauseVerdict::Kept => judged.kept,
            ClauseVerdict::NotSeen => {
                let why = judged.why_unseen.map_or_else(String::new, |why| format!("{why}; "));
                vec![format!("{why}to see it: {how}")]
            }
        }
    }

    /// The report for machines.
    #[must_use]
    pub fn json(&self) -> Value {
        let clauses = CLAUSES.iter().map(|clause| {
            let verdict = self.verdict(clause.0).word().to_lowercase();
            json!({ "clause": format!("M{}", clause.0), "about": clause.1, "verdict": verdict, "evidence": self.lines(clause) })
        });
        json!({
            "machine": self.machine,
            "kept": self.clauses(ClauseVerdict::Kept).len(),
            "broken": self.clauses(ClauseVerdict::Broken).len(),
            "not_seen": self.clauses(ClauseVerdict::NotSeen).len(),
            "clauses": clauses.collect::<Vec<_>>(),
        })
    }
}

impl fmt::Display for ClauseReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for clause in CLAUSES {
            let (number, about, _) = clause;
            writeln!(f, "M{number:<3} {:<9} {about}", self.verdict(*number).word())?;
            for line in self.lines(clause) {
                writeln!(f, "               {line}")?;
            }
        }
        let count = |verdict| self.clauses(verdict).len();
        let (kept, broken, unseen) =
            (count(ClauseVerdict::Kept), count(ClauseVerdict::Broken), count(ClauseVerdict::NotSeen));
        write!(f, "{}: {kept} clauses kept, {broken} broken, {unseen} not seen", self.machine)
    }
}
