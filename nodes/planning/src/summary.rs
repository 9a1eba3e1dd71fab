// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Figures of a planned job, as `summary.json` has them.

use super::PreparedJob;
use super::cut_table::pass_rows;
use super::deflection::{self, LobeDeflection};
use super::dresses::{DressSummary, dresses};
use super::finishing::{self, FinishingSummary};
use super::lifts::{self, LiftSummary};
use super::lobe_shapes::ShapeSummary;
use super::part_support::{self, LobeSupport};
use super::turn::LobeTurn;
use super::turn_summary::{BoundSummary, RemovalClass, bounds_used, law_name, removal_classes};
use super::wheel_changes::{WheelChangeSummary, wheel_changes};
use super::wide_lobes::PlungeSummary;
use camwright::math::units::{TURN_RAD, deg_from_rad, um_from_mm, wrap_turn};
use camwright::motion::speed_plan::{LimitUse, SpeedPlan};
use camwright::planner::PlannedLobe;
use serde::Serialize;

/// Figures of a job.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Name of the job.
    pub job: String,
    /// One line about it.
    pub title: String,
    /// Machine it was planned for.
    pub machine: String,
    /// Wheel radius it was planned for.
    pub wheel_radius_mm: f64,
    /// SHA-256 of the job with everything it names.
    pub job_hash: String,
    /// Hash of the machine.
    pub machine_hash: String,
    /// Hash of the plan.
    pub plan_hash: String,
    /// Time of the whole job, homing included.
    pub duration_s: f64,
    /// The same job with rotary indexing before each lobe, the conventional way.
    pub duration_with_indexing_s: f64,
    /// Predicted time saved by C turning on between the lobes (s), where it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saved_by_turning_on_s: Option<f64>,
    /// The difference: what not turning the part saves.
    pub saved_s: f64,
    /// True if the job uses rotary indexing.
    pub rotary_indexing: bool,
    /// Time on the way that the order of the lobes saves the table, where the fastest was sought.
    pub saved_by_order_s: Option<f64>,
    /// Largest use of an axis limit anywhere in the plan, as its forward check found it; 1 is the limit.
    pub max_limit_ratio: f64,
    /// Remarks on the order that the supports of the part ask for; none for a job without `part_support`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub support_order: Vec<String>,
    /// The wheels that the job mounts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wheel_changes: Vec<WheelChangeSummary>,
    /// The dresses of the wheel, in their order.
    pub dresses: Vec<DressSummary>,
    /// One for each profile whose lift is a table.
    pub lifts: Vec<LiftSummary>,
    /// One for each lobe, in the order of machining.
    pub lobes: Vec<LobeSummary>,
}

/// Figures of a lobe.
#[derive(Debug, Clone, Serialize)]
pub struct LobeSummary {
    pub name: String,
    /// Limit switch of its station.
    pub station: String,
    pub profile: String,
    pub phase_deg: f64,
    /// Cam angle at which cutting begins and ends.
    pub start_deg: f64,
    /// Block of the table from which it is read.
    pub start_block: u32,
    /// Time from the start of indexing to the end of retraction.
    pub duration_s: f64,
    /// Turns of all passes, spark-out included.
    pub turns: u32,
    pub max_lift_mm: f64,
    /// Largest deviation of the lift law from the printed table; `None` for a formula.
    pub lift_deviation_mm: Option<f64>,
    /// Pressure angle largest in size.
    pub max_pressure_angle_deg: f64,
    /// Largest wheel that fits the contour; none where any does.
    pub largest_wheel_radius_mm: Option<f64>,
    /// Throw and contact of a crank pin; none of a lobe about the axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crank_pin: Option<CrankPinSummary>,
    /// The plunge of a lobe wider than the wheel that this is; none of a lobe that the wheel covers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plunge: Option<PlungeSummary>,
    /// Taper and crown over the width; none of a straight lobe under a straight rim.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<ShapeSummary>,
    /// Knots of the path over one turn.
    pub path_knots: usize,
    /// Largest distance from the contour of the points that the path grinds.
    pub contour_error_mm: f64,
    /// Deflection of wheel and part; `None` on a rigid machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub giving_way: Option<LobeDeflection>,
    /// Expected finishing turns after the correction; none for a job without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finishing: Option<FinishingSummary>,
    /// Stiffness of the part on its supports; none for a job without `part_support`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part_support: Option<LobeSupport>,
    /// The passes in their order.
    pub passes: Vec<PassSummary>,
}

/// Figures of a crank pin.
#[derive(Debug, Clone, Serialize)]
pub struct CrankPinSummary {
    /// Distance of the pin's centre from the axis.
    pub throw_mm: f64,
    /// Largest angle between the wheel line and the normal of the contact over the turn.
    pub max_contact_angle_deg: f64,
    /// Smallest wheel that follows the pin; 0 where any does.
    pub smallest_wheel_radius_mm: f64,
}

impl CrankPinSummary {
    fn from_lobe(lobe: &PlannedLobe) -> Option<Self> {
        let contour = &lobe.design.contour;
        let arm_mm = contour.base_radius_mm() + lobe.tool_path.wheel_radius_mm();
        contour.is_pin().then(|| Self {
            throw_mm: contour.throw_mm(),
            // Where the line of both centres stands square to the throw: sin β = e/(R + r).
            max_contact_angle_deg: deg_from_rad((contour.throw_mm() / arm_mm).asin()),
            smallest_wheel_radius_mm: contour.smallest_wheel_radius_mm().unwrap_or(0.0),
        })
    }
}

/// Figures of one pass over a lobe.
#[derive(Debug, Clone, Serialize)]
pub struct PassSummary {
    pub name: String,
    /// Its speed law, as job files name it.
    pub speed_law: &'static str,
    /// Time of the cut.
    pub cut_s: f64,
    pub turns: u32,
    pub infeed_turns: u32,
    /// Infeed of each turn, where the job has a list of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub infeed_per_turn_um: Vec<f64>,
    /// Time of one turn at the programmed speed.
    pub turn_s: f64,
    /// A time below which no turn under the speed law can be; none at a constant work speed.
    pub least_turn_s: Option<f64>,
    /// Time of a turn at the constant work speed that has the same largest removal rate.
    pub constant_speed_turn_s: Option<f64>,
    /// Slowest and fastest headstock speed of a turn.
    pub work_speed_rpm: [f64; 2],
    /// Longest stop on the path that keeps every limit.
    pub stop_s: f64,
    /// Largest specific removal rate.
    pub max_removal_mm2_s: f64,
    /// Share of a turn's time at each class of the specific removal rate.
    pub removal_classes: Vec<RemovalClass>,
    /// Bounds of the speed, with their share of a turn's time and their angles.
    pub bounds: Vec<BoundSummary>,
    /// Utilisation of each axis limit.
    pub limits: Vec<LimitSummary>,
}

/// Use of one limit.
#[derive(Debug, Clone, Serialize)]
pub struct LimitSummary {
    pub axis: &'static str,
    /// velocity, acceleration or jerk.
    pub quantity: &'static str,
    /// Unit of the two values.
    pub unit: &'static str,
    pub value: f64,
    /// Most allowed while planning.
    pub allowed: f64,
    pub ratio: f64,
    /// Cam angle at which it is met.
    pub cam_angle_deg: f64,
}

/// Predicted time of each lobe, from the start of indexing to the end of retraction (s).
#[must_use]
pub fn lobe_times_s(prepared: &PreparedJob) -> Vec<f64> {
    let cycle_s = prepared.machine.cycle_time_s();
    let ticks = |index: usize| -> u64 {
        let second = prepared.expected_correction.iter().flat_map(|second| &second.plan.segments);
        let before = prepared.measuring.iter().flat_map(|measuring| &measuring.planned.plan.segments);
        let segments = before.chain(&prepared.planned.plan.segments).chain(second);
        segments.filter(|segment| segment.lobe == Some(index)).map(|segment| segment.ticks).sum()
    };
    (0..prepared.planned.lobes.len()).map(|index| ticks(index) as f64 * cycle_s).collect()
}

/// Everything about a planned job but its curves.
#[must_use]
pub fn summary(prepared: &PreparedJob) -> Summary {
    let plan = &prepared.planned.plan;
    let lobes: Vec<LobeSummary> = (prepared.planned.lobes.iter().zip(lobe_times_s(prepared)).enumerate())
        .map(|(index, (lobe, duration_s))| lobe_summary(prepared, index, lobe, duration_s))
        .collect();
    Summary {
        job: plan.job.clone(),
        title: prepared.job.title.clone(),
        machine: prepared.machine.name.clone(),
        wheel_radius_mm: prepared.wheel_radius_mm,
        job_hash: prepared.provenance.job_hash.clone(),
        machine_hash: prepared.provenance.machine_hash.clone(),
        plan_hash: prepared.plan_hash().to_owned(),
        duration_s: prepared.duration_s(),
        duration_with_indexing_s: prepared.duration_s() + prepared.planned.saved_by_not_indexing_s(),
        saved_by_turning_on_s: prepared.planned.saved_by_turning_on_s(),
        saved_s: prepared.planned.saved_by_not_indexing_s(),
        rotary_indexing: prepared.job.spec.rotary_indexing,
        saved_by_order_s: prepared.job.lobe_order.as_ref().map(|order| {
            let ticks = order.saved_ticks as f64;
            ticks * prepared.machine.cycle_time_s()
        }),
        max_limit_ratio: prepared.planned.report.max_ratio(),
        support_order: part_support::order_lines(prepared, &lobes),
        wheel_changes: wheel_changes(prepared),
        dresses: dresses(prepared),
        lifts: lifts::summaries(&prepared.job, Some(prepared)),
        lobes,
    }
}

fn lobe_summary(prepared: &PreparedJob, index: usize, lobe: &PlannedLobe, duration_s: f64) -> LobeSummary {
    let spec = &prepared.job.spec;
    let profile = &spec.profiles[spec.lobes[index].profile];
    LobeSummary {
        name: lobe.design.name.clone(),
        station: lobe.design.station.clone(),
        profile: profile.name.clone(),
        phase_deg: deg_from_rad(lobe.design.phase_rad),
        start_deg: deg_from_rad(lobe.start_rad),
        start_block: lobe.start_block,
        duration_s,
        turns: lobe.passes.iter().map(SpeedPlan::turns).sum(),
        max_lift_mm: profile.lift.max_lift_mm(),
        lift_deviation_mm: profile.lift.reading().map(|reading| reading.max_deviation_mm),
        max_pressure_angle_deg: deg_from_rad(lobe.design.contour.max_pressure_angle().value),
        largest_wheel_radius_mm: lobe.design.contour.largest_wheel_radius_mm(),
        crank_pin: CrankPinSummary::from_lobe(lobe),
        plunge: PlungeSummary::from_design(prepared, &lobe.design),
        shape: ShapeSummary::from_design(prepared, &lobe.design),
        path_knots: lobe.tool_path.accuracy().knots,
        contour_error_mm: lobe.tool_path.accuracy().contour_error_mm,
        giving_way: deflection::from_lobe(prepared, index),
        finishing: finishing::forecast(prepared, index),
        part_support: part_support::at_lobe(prepared, index),
        passes: (0..lobe.passes.len()).map(|pass| pass_summary(prepared, index, lobe, pass)).collect(),
    }
}

fn pass_summary(prepared: &PreparedJob, index: usize, lobe: &PlannedLobe, pass: usize) -> PassSummary {
    let sense = f64::from(prepared.machine.rotation_sense);
    let speed = &lobe.passes[pass];
    let rpm = |rad_s: f64| rad_s * 60.0 / TURN_RAD;
    let (slowest, fastest) = speed.speed_range_rad_s();
    let stop_s = speed.stop_ticks() as f64 * prepared.machine.cycle_time_s();
    let limit = |found: &LimitUse| LimitSummary {
        axis: found.axis.joint(),
        quantity: found.quantity.name(),
        unit: found.quantity.unit(found.axis),
        value: found.value,
        allowed: found.allowed,
        ratio: found.ratio(),
        cam_angle_deg: deg_from_rad(wrap_turn(sense * found.angle_rad)),
    };
    let turn = LobeTurn::new(prepared, index, pass);
    let spec = &prepared.job.spec.passes_of(index)[pass];
    PassSummary {
        name: spec.name.clone(),
        speed_law: law_name(&spec.speed),
        cut_s: speed.law().end(),
        turns: speed.turns(),
        infeed_turns: speed.infeed().schedule().turns(),
        infeed_per_turn_um: spec.infeed_of_turns_mm.iter().map(|mm| um_from_mm(*mm)).collect(),
        turn_s: speed.turn_s(),
        least_turn_s: speed.minimum_turn_s(),
        constant_speed_turn_s: turn.as_ref().map(LobeTurn::constant_speed_turn_s),
        work_speed_rpm: [rpm(slowest), rpm(fastest)],
        stop_s,
        max_removal_mm2_s: pass_rows(prepared, index, lobe, pass).map(|row| row.removal_mm2_s).fold(0.0, f64::max),
        removal_classes: turn.as_ref().map(removal_classes).unwrap_or_default(),
        bounds: turn.as_ref().map(bounds_used).unwrap_or_default(),
        limits: speed.uses().iter().map(limit).collect(),
    }
}
