// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Journals ground to gauge: when the gauge read the size that ended the infeed, and how much infeed it took.

use super::findings::Findings;
use super::table::table as html_table;
use super::text::{fixed, um};
use camwright::machine::description::Axis;
use camwright::machine::wheel_state::mm_from_nm;
use camwright::math::units::{TURN_RAD, um_from_mm};
use camwright::motion::plan::SegmentKind;
use camwright_files::convert::{m_from_mm, mm_from_m};
use camwright_msgs::camwright_msgs::msg::{AppliedInput, PartLobe};
use camwright_planning::markup::escape;
use camwright_planning::{AnyPrepared, PreparedJob};

/// Name of the input that the gauge closes.
const SIZE_REACHED: &str = "size_reached";

/// Infeed of a journal that ended at a size.
#[derive(Debug, Clone, PartialEq)]
struct SizeRead {
    lobe: usize,
    /// Tick of the reading.
    tick: u64,
    /// Size that ended the infeed (mm).
    diameter_mm: f64,
    /// Turns of the cut at the reading, and its turns with infeed.
    turn: f64,
    infeed_turns: u32,
    /// Infeed of the cut until it ended, and all of its planned infeed (mm).
    infed_mm: f64,
    planned_mm: f64,
}

impl SizeRead {
    /// Reads an input of the interpolator; `None` if it is another one, or the plan is unknown.
    fn from_input(findings: &Findings<'_>, prepared: &PreparedJob, input: &AppliedInput) -> Option<Self> {
        if input.kind != AppliedInput::FEEDBACK || input.text != SIZE_REACHED {
            return None;
        }
        let story = findings.story;
        let stretch = story.stretches.iter().rfind(|stretch| stretch.cuts() && stretch.from <= input.source_tick)?;
        // A job that measured its stock drove another plan than the one that is planned again.
        if story.plans.get(stretch.plan)?.0 != prepared.plan_hash() {
            return None;
        }
        let (plan, number) = (&prepared.planned.plan, usize::try_from(stretch.segment).ok()?);
        let SegmentKind::Cut(cut) = &plan.segments.get(number)?.kind else { return None };
        let infeed = plan.angle_laws.get(cut.infeed)?;
        let turn_counts = prepared.machine.axis(Axis::C).scale.counts(TURN_RAD);
        // The place within the turn is exact; which turn it is, the state of the interpolator says.
        let within = (input.counts - cut.start_counts).rem_euclid(turn_counts) as f64 / turn_counts as f64;
        let states = findings.recorded.states.iter().map(|at| &at.message);
        let reported =
            states.rev().find(|state| state.tick <= input.source_tick && state.segment == stretch.segment)?;
        let cycle_s = prepared.machine.cycle_time_s();
        let passed = |ticks: u64| ticks as f64 * cycle_s / cut.turn_s * reported.feed_override;
        let expected = reported.turn + passed(input.source_tick - reported.tick);
        let turn = within + (expected - within).round().max(0.0);
        let ended = turn + passed(input.tick.saturating_sub(1).saturating_sub(input.source_tick));
        let level_mm = |turns: f64| infeed.sample(turns * TURN_RAD).value;
        Some(Self {
            lobe: stretch.lobe?,
            tick: input.source_tick,
            diameter_mm: mm_from_nm(plan.size_of(number)?.diameter_nm),
            turn,
            infeed_turns: cut.infeed_turns,
            infed_mm: level_mm(0.0) - level_mm(ended),
            planned_mm: level_mm(0.0) - level_mm(f64::from(cut.turns)),
        })
    }
}

/// Mean diameter of a finished journal (mm).
fn mean_diameter_mm(part: &PartLobe) -> f64 {
    2.0 * mm_from_m(part.radius.iter().sum::<f64>() / part.radius.len() as f64)
}

/// Writes the table of sizes, if the infeed of any journal ended at one.
pub(super) fn table(out: &mut String, findings: &Findings<'_>) {
    let Ok(AnyPrepared::Ground(prepared)) = findings.again else { return };
    let Some((first, last)) = findings.story.ticks else { return };
    let inputs = findings.recorded.inputs.iter().map(|at| &at.message);
    let inputs = inputs.filter(|input| (first..=last).contains(&input.tick));
    let read: Vec<SizeRead> = inputs.filter_map(|input| SizeRead::from_input(findings, prepared, input)).collect();
    if read.is_empty() {
        return;
    }
    let row = |read: &SizeRead| {
        let name = findings.story.names().get(read.lobe).map_or("", String::as_str);
        let finished = findings.story.outlines.iter().find(|part| part.name == name && !part.radius.is_empty());
        let at = findings.seconds(read.tick).map_or_else(|| "–".into(), |at| fixed(at, 3));
        vec![
            escape(name),
            fixed(read.diameter_mm, 4),
            at,
            format!("{} of {}", fixed(read.turn, 2), read.infeed_turns),
            format!("{} of {}", fixed(um_from_mm(read.infed_mm), 1), fixed(um_from_mm(read.planned_mm), 1)),
            finished.map_or_else(|| "–".into(), |part| fixed(mean_diameter_mm(part), 4)),
            finished
                .map_or_else(|| "–".into(), |part| fixed(um(m_from_mm(read.diameter_mm - mean_diameter_mm(part))), 2)),
        ]
    };
    out.push_str("<section id=\"size\"><h2>Gauge-controlled size</h2>");
    let heads = [
        ("journal", true),
        ("infeed ends at mm", false),
        ("read at s", false),
        ("turn", false),
        ("infeed used µm", false),
        ("finished, mean mm", false),
        ("taken off since µm", false),
    ];
    html_table(out, &heads, &read.iter().map(row).collect::<Vec<_>>());
    out.push_str("<p class=\"faint\">Diameters. The gauge reads the mean of a turn; the infeed ends when the reading is in sight of the interpolator, and spark-out takes off what wheel and part deflect.</p></section>\n");
}
