// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stock of journals, measured before anything is cut, and the turns of infeed that are omitted then.
//!
//! ```text
//! home C · wheel up to speed · for each journal: table to it, one turn under the gauge      measuring plan
//! for each journal: grind it, from as near above it as whole turns of infeed allow          plan that follows it
//! ```
//! The wheel stays at its home position until everything has been measured: a journal that is larger than the job allows for is found
//! before the wheel comes near it.
//!
//! Above a journal of radius R with measured stock s, X begins at the last of the job's own whole turns that is still s and the margin
//! above R: with o = RT of all passes and the allowance, a feed f per turn and s + m to keep, ⌊(o − s − m)/f⌋ turns are omitted. All turns
//! that stay are those of the job, at its feeds, so the finished journal is the same. Two opposed contacts show a diameter: half of
//! the largest is the largest radius but for what leaves diameters as they are, eccentricity, bend and waves of an odd count. The margin
//! is for those, and for what the gauge's zero differs from that of `x_axis`.

use super::check_forwards;
use super::error::PlanError;
use super::gouge::GougeRequest;
use super::host::OneByOne;
use super::journal_readings::{JournalReadings, UncorrectedJournal, seen};
use super::lobe::{self, LobePlanner, PlannedLobe};
use super::sequence::Sequence;
use super::{Build, PlanStart, PlannedJob, schedules};
use crate::gauging::gauged_tick::GaugedTick;
use crate::gauging::journal::JournalError;
use crate::job::grinding::JobSpec;
use crate::job::infeed::InfeedSchedule;
use crate::job::raw_part::RawPart;
use crate::machine::description::{Axis, GaugeKind, MachineDescription};
use crate::machine::wheel_state::WheelNow;
use crate::math::range::minimum_and_maximum;
use crate::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use crate::motion::plan::{Half, Plan, SegmentKind};
use crate::planner::plan_check::{PlanReport, check_plan};
use alloc::string::String;
use alloc::vec::Vec;

/// Angle at either end of a turn under the gauge that is not looked at (rad): there C seems to turn before it does, or after.
const UNREAD_RAD: f64 = TURN_RAD / 180.0;
/// Share of a turn that must have been read: all but what is not looked at, and a little.
const TURN_SHARE: f64 = 0.98;

/// Turns in the air that are left where the stiffness is measured: its friction is measured in one of them.
const AIR_TURNS: f64 = 1.5;
/// Turns that are left of the first pass where the stiffness is measured: one in the air, one into the cut, two to measure.
const MIN_TURNS: u32 = 4;

/// Rounding tolerance of equal positions (mm).
const ROUNDING_MM: f64 = 1e-9;

/// The plan that measures.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedMeasuring {
    pub plan: Plan,
    /// Result of the forward check.
    pub report: PlanReport,
    /// Predicted time of measuring alone, without homing and wheel start (s).
    pub measuring_s: f64,
    /// C up to which every journal is read (rad): a little before it rests, for the last readings may be on their way yet.
    pub read_to_rad: Vec<f64>,
}

/// Gauge result of a journal, and the turns skipped because of it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkippedTurns {
    /// Name of the journal.
    pub lobe: String,
    /// Its stock, half of its largest diameter less the radius that it is to have (mm).
    pub stock_mm: f64,
    /// Start of the infeed above that radius (mm).
    pub begins_mm: f64,
    /// Turns with infeed that are omitted.
    pub infeed_turns: u32,
    /// Turns without, of whole passes that are omitted.
    pub spark_out_turns: u32,
}

impl core::fmt::Display for SkippedTurns {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { lobe, infeed_turns, spark_out_turns, .. } = self;
        let (stock_um, begins_um) = (um_from_mm(self.stock_mm), um_from_mm(self.begins_mm));
        write!(
            f,
            "lobe {lobe}: {stock_um:.1} um of stock by the gauge; the infeed begins at {begins_um:.1} um, {infeed_turns} turns with infeed and {spark_out_turns} without are skipped"
        )
    }
}

/// A job planned anew for the stock that was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredJob {
    /// The plan and what it was made of; it begins where the measuring plan ends.
    pub planned: PlannedJob,
    /// Skipped turns, in the order of the journals.
    pub skipped: Vec<SkippedTurns>,
    /// Time saved in the cuts (s).
    pub saved_s: f64,
}

/// Plans the measuring of a job whose lobes are as planned: the first of its plans.
///
/// # Errors
/// A job that measures none, a step that cannot be made.
pub fn plan_measuring(
    job: &JobSpec,
    machine: &MachineDescription,
    wheel: impl Into<WheelNow>,
    lobes: &[PlannedLobe],
    start: Option<PlanStart>,
) -> Result<PlannedMeasuring, PlanError> {
    job.check(machine)?;
    let speed_rad_s = job.measure_stock.map_or(TURN_RAD, |stock| stock.speed_rad_s);
    let start = start.unwrap_or_else(|| PlanStart::at_home(job, machine));
    let mut sequence = Sequence::new(job, machine, &[], start);
    if machine.dresser.is_some() {
        sequence.expect_wheel(wheel.into().radius_mm);
    }
    sequence.prepare(None)?;
    let prepared_ticks = sequence.ticks();
    let mut read_to_rad = Vec::with_capacity(job.lobes.len());
    for index in 0..job.lobes.len() {
        sequence.index_to(index)?;
        read_to_rad.push(sequence.gauge(index, speed_rad_s)? - UNREAD_RAD);
    }
    let measuring_s = (sequence.ticks() - prepared_ticks) as f64 * machine.cycle_time_s();
    let mut plan = sequence.stand_by()?;
    plan.duration_with_indexing_s = plan.duration_s;
    super::clearance::check_clearance(job, machine, lobes, &plan, start.counts)?;
    let report = check_plan(&plan, machine, start.counts)?;
    Ok(PlannedMeasuring { plan, report, measuring_s, read_to_rad })
}

/// Stock of every journal (mm) from what was logged of it while it turned under the gauge.
///
/// # Errors
/// Readings that are lost, or no numbers, or less than a turn of them.
pub fn measured_stocks(
    machine: &MachineDescription,
    measuring: &PlannedMeasuring,
    lobes: &[PlannedLobe],
    logs: &[JournalReadings],
) -> Result<Vec<f64>, UncorrectedJournal> {
    let stock_mm = |lobe: &PlannedLobe, log: &JournalReadings, to_rad: f64| {
        seen(machine, lobe)?;
        let gauged = the_turn(&log.gauged, to_rad);
        if let Some(pair) = gauged.windows(2).find(|pair| pair[1].tick != pair[0].tick + 1) {
            return Err(JournalError::Lost { from: pair[0].tick, to: pair[1].tick });
        }
        let turned_rad = gauged.last().zip(gauged.first()).map_or(0.0, |(last, first)| last.c_rad - first.c_rad);
        if turned_rad < TURN_SHARE * TURN_RAD {
            return Err(JournalError::NotATurn { turned_deg: deg_from_rad(turned_rad) });
        }
        if let Some(broken) = gauged.iter().find(|gauged| !gauged.value_mm.is_finite()) {
            return Err(JournalError::NoReading { tick: broken.tick });
        }
        let (_, max_mm) = minimum_and_maximum(gauged.iter().map(|gauged| gauged.value_mm));
        let radius_mm = match machine.gauge.map(|gauge| gauge.kind) {
            Some(GaugeKind::Radius) => max_mm,
            _ => 0.5 * max_mm,
        };
        Ok(radius_mm - lobe.design.contour.radius_at(0.0))
    };
    let each = lobes.iter().zip(logs).zip(&measuring.read_to_rad).map(|((lobe, log), to_rad)| {
        stock_mm(lobe, log, *to_rad).map_err(|source| UncorrectedJournal { lobe: lobe.design.name.clone(), source })
    });
    each.collect()
}

/// Returns the readings of the turn that ends beyond this angle (rad).
fn the_turn(gauged: &[GaugedTick], to_rad: f64) -> &[GaugedTick] {
    let from_rad = to_rad - TURN_RAD + 2.0 * UNREAD_RAD;
    let until = gauged.iter().rposition(|gauged| gauged.c_rad <= to_rad).map_or(0, |last| last + 1);
    let from = gauged[..until].iter().rposition(|gauged| gauged.c_rad < from_rad).map_or(0, |last| last + 1);
    &gauged[from..until]
}

/// Plans a job that has been planned `whole` once more, for the stock of every journal (mm), from where its measuring plan ends.
///
/// # Errors
/// A journal that has more stock than the job allows for, or none; otherwise as [`plan_job`](super::plan_job).
pub fn plan_measured_job(
    job: &JobSpec,
    machine: &MachineDescription,
    wheel: impl Into<WheelNow>,
    whole: &PlannedJob,
    measuring: &PlannedMeasuring,
    stocks_mm: &[f64],
) -> Result<MeasuredJob, PlanError> {
    job.check(machine)?;
    let all = schedules(job, machine)?;
    let contours = lobe::contours(job, &OneByOne)?;
    let course = lobe::wheel_course(job, machine, &contours, &wheel.into().into())?;
    let shapes = lobe::shapes(job, machine, &contours, &course, &OneByOne)?;
    let start = PlanStart { counts: measuring.report.end_counts, c_homed: true };
    let start_c_counts = start.counts[Axis::C.index()];
    let turn_counts = machine.axis(Axis::C).scale.counts(TURN_RAD);
    let mut c_counts = start_c_counts;
    let (mut lobes, mut begins, mut skipped) = (Vec::new(), Vec::new(), Vec::new());
    for (index, stock_mm) in (0..job.lobes.len()).zip(stocks_mm.iter().copied()) {
        let (shorter, left_out) = shortened(job, &all, index, stock_mm)?;
        let of_lobe = schedules(&shorter, machine)?;
        let planner = LobePlanner { job: &shorter, machine, shapes: &shapes, schedules: &of_lobe, wheel: &course };
        let begin = planner.begin(index, c_counts);
        let planned = planner.lobe(index, begin, None, None)?;
        let turns: u32 = planned.passes.iter().map(crate::motion::speed_plan::SpeedPlan::turns).sum();
        c_counts += i64::from(turns) * turn_counts;
        lobes.push(planned);
        begins.push(begin);
        skipped.push(left_out);
    }
    lobe::check_travel(job, machine, &all, &lobes, None)?;
    let planner = LobePlanner { job, machine, shapes: &shapes, schedules: &all, wheel: &course };
    let build = Build { planner, stopping: &lobes, start, expected_wheel_mm: None };
    let mut plan = build.steps(Sequence::new(job, machine, &shapes, start), &begins, false)?;
    plan.half = if job.is_corrected().is_some() { Half::Middle } else { Half::Second };
    plan.duration_with_indexing_s = plan.duration_s + whole.saved_by_not_indexing_s();
    let report = check_forwards(&GougeRequest {
        job,
        machine,
        lobes: &lobes,
        plan: &plan,
        start_counts: start.counts,
        c_homed: start.c_homed,
        stock_mm: stocks_mm,
        corrections: &[],
    })?;
    let saved_s = (cut_ticks(&whole.plan) as f64 - cut_ticks(&plan) as f64) * machine.cycle_time_s();
    let dresses = whole.dresses.clone();
    let planned = PlannedJob { plan, lobes, dresses, duration_with_stops_s: None, report, start_c_counts };
    Ok(MeasuredJob { planned, skipped, saved_s })
}

/// Predicted ticks of the cuts of a plan.
fn cut_ticks(plan: &Plan) -> u64 {
    let cuts = plan.segments.iter().filter(|segment| matches!(segment.kind, SegmentKind::Cut(_)));
    cuts.map(|segment| segment.ticks).sum()
}

/// The job with what of its passes a journal of this stock (mm) needs, and what is omitted.
fn shortened(
    job: &JobSpec,
    schedules: &[InfeedSchedule],
    index: usize,
    stock_mm: f64,
) -> Result<(JobSpec, SkippedTurns), PlanError> {
    let lobe = &job.lobes[index].name;
    let margin_mm = job.measure_stock.map_or(0.0, |stock| stock.margin_mm);
    let begins_mm = |number: usize, turn: u32| schedules[number].begins_mm(turn);
    let (farthest_mm, needed_mm) = (begins_mm(0, 0), stock_mm + margin_mm);
    if stock_mm.is_nan() || farthest_mm + ROUNDING_MM < needed_mm {
        let (lobe, expected_mm) = (lobe.clone(), job.stock_mm);
        return Err(PlanError::TooMuchStock {
            lobe,
            stock_mm,
            expected_mm,
            max_mm: farthest_mm - margin_mm,
            margin_mm,
        });
    }
    if stock_mm <= job.allowance_mm() {
        return Err(PlanError::NoStock { lobe: lobe.clone(), stock_mm, min_mm: job.allowance_mm() });
    }
    let identifies = job.identification.is_some();
    let needed_mm = needed_mm + if identifies { AIR_TURNS * schedules[0].max_per_turn_mm() } else { 0.0 };
    let max_turns = |number: usize, turns: u32| match (identifies, number) {
        (true, 0) => turns.saturating_sub(MIN_TURNS) + 1,
        // Of a job that measures its stiffness every feed is needed.
        (true, _) => 0,
        (false, _) => turns,
    };
    let places = schedules
        .iter()
        .enumerate()
        .flat_map(|(number, schedule)| (0..max_turns(number, schedule.turns())).map(move |turn| (number, turn)));
    // The offsets fall from place to place.
    let fits = |(number, turn): &(usize, u32)| begins_mm(*number, *turn) >= needed_mm - ROUNDING_MM;
    let (number, turn) = places.take_while(fits).last().unwrap_or((0, 0));
    let mut shorter = JobSpec { stock_mm, raw_part: RawPart::default(), ..job.clone() };
    let left_out: Vec<_> = shorter.passes.drain(..number).collect();
    let before = &schedules[..number];
    let infeed_turns = before.iter().map(InfeedSchedule::turns).sum::<u32>() + turn;
    let spark_out_turns = left_out.iter().map(|pass| pass.spark_out_turns).sum();
    if let Some(first) = shorter.passes.first_mut().filter(|_| turn > 0) {
        let per_turn_mm = f64::from(job.blocks_per_turn) * first.infeed_per_block_mm;
        let turns = f64::from(schedules[number].turns() - turn);
        first.total_infeed_mm = per_turn_mm * turns;
        if !first.infeed_of_turns_mm.is_empty() {
            first.infeed_of_turns_mm.drain(..turn as usize);
            first.total_infeed_mm = first.infeed_of_turns_mm.iter().sum();
            first.infeed_per_block_mm = first.total_infeed_mm / (turns * f64::from(job.blocks_per_turn));
        }
    }
    let skipped = SkippedTurns {
        lobe: lobe.clone(),
        stock_mm,
        begins_mm: begins_mm(number, turn),
        infeed_turns,
        spark_out_turns,
    };
    Ok((shorter, skipped))
}
