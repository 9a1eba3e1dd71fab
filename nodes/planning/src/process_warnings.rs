// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Warnings about the process of a planned job: heat, slowed turns, and tables too coarse for their turns.

use super::finding::{Finding, warning};
use super::turn::LobeTurn;
use super::{PreparedJob, error_location, pulses};
use camwright::job::grinding::{PassSpec, SpeedLaw};
use camwright::machine::description::{Axis, MotionLimits};
use camwright::math::units::{TURN_RAD, deg_from_rad, rpm_from_rad_s, um_from_mm, wrap_turn};
use camwright::motion::speed_plan::{Bound, LimitedQuantity};
use camwright_files::job_file::FORMULA_BLOCKS;
use std::collections::BTreeMap;

/// Turns of a job from which on a table is expected to be worth them: a camshaft takes some 30.
const MANY_TURNS: u32 = 500;

/// Turns of infeed of a pass from which on they are expected to be an oversight.
const MANY_INFEED_TURNS: f64 = 50.0;

/// Share of a turn's time from which on a limit slows a pass for much of it.
const MUCH_OF_A_TURN: f64 = 0.5;

/// Warnings about the process of a planned job.
pub(super) fn of_process(prepared: &PreparedJob) -> Vec<Finding> {
    let mut findings: Vec<Finding> = coarse_tables(prepared);
    findings.extend(few_rows(prepared));
    findings.extend(pulses::warnings(prepared));
    for pass in 0..prepared.job.spec.passes.len() {
        let turns: Vec<(usize, LobeTurn<'_>)> = (0..prepared.planned.lobes.len())
            .filter_map(|lobe| Some((lobe, LobeTurn::new(prepared, lobe, prepared.job.spec.pass_of(lobe, pass)?)?)))
            .collect();
        findings.extend(burns(prepared, pass, &turns));
        findings.extend(slowed(prepared, pass, &turns));
    }
    findings
}

fn pass_name(prepared: &PreparedJob, pass: usize) -> &str {
    &prepared.job.spec.passes[pass].name
}

fn lobe_name(prepared: &PreparedJob, lobe: usize) -> &str {
    &prepared.planned.lobes[lobe].design.name
}

/// Hottest moment of a pass, where it burns the part.
///
/// In a turn with the whole infeed of a turn: deflection makes the first turns shallower, and later ones as deep.
fn burns(prepared: &PreparedJob, pass: usize, turns: &[(usize, LobeTurn<'_>)]) -> Option<Finding> {
    let process = prepared.machine.process.as_ref()?;
    let hottest = turns.iter().filter_map(|(lobe, turn)| {
        let index = |c: camwright::math::hermite::Sample| {
            process.burn_index(&turn.bounds.cutting.cut(turn.bounds.path.sample(c.value), c.first))
        };
        let points = turn.points.iter().map(|point| (index(point.c), point.c.value));
        points.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(index, angle)| (index, *lobe, angle))
    });
    let (index, lobe, angle_rad) = hottest.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|found| found.0 > 1.0)?;
    let (pass_name, name) = (pass_name(prepared, pass), lobe_name(prepared, lobe));
    let cam_deg = deg_from_rad(wrap_turn(f64::from(prepared.machine.rotation_sense) * angle_rad));
    // The temperature goes with depth to the power of 3/4, and with the root of the speed.
    let (depth, speed) = (index.powf(-4.0 / 3.0), index.powi(-2));
    let percent = |share: f64| (100.0 * share).floor().max(1.0);
    let remedy = match prepared.job.spec.passes[pass].speed {
        SpeedLaw::ConstantWorkSpeed { .. } => {
            format!(" or work_speed_rpm to {:.0} %, or use speed.law: constant_temperature", percent(speed))
        }
        SpeedLaw::ConstantTemperature { .. } => String::from(", or the reference cut of speed"),
        _ => String::from(", or use speed.law: constant_temperature"),
    };
    let key = error_location::infeed_key(&prepared.job, pass_name);
    let message = format!(
        "lobe {name}, pass {pass_name}: the predicted burn index is {index:.2} at cam angle {cam_deg:.1} deg, above 1: the part burns; lower \
         {key} to {:.0} %{remedy}",
        percent(depth)
    );
    Some(warning(prepared.job.document.error(&key, message)))
}

/// The limit of an axis that slows a pass for much of a turn.
fn slowed(prepared: &PreparedJob, pass: usize, turns: &[(usize, LobeTurn<'_>)]) -> Option<Finding> {
    // A fastest turn is always at a limit.
    if matches!(prepared.job.spec.passes[pass].speed, SpeedLaw::TimeOptimal { .. }) {
        return None;
    }
    let limited = turns.iter().filter_map(|(lobe, turn)| {
        let mut shares: BTreeMap<usize, f64> = BTreeMap::new();
        for point in &turn.points {
            if let Some(bound @ (Bound::Limit(..) | Bound::WheelPower)) = point.active {
                let index = Bound::ALL.iter().position(|other| *other == bound)?;
                *shares.entry(index).or_default() += point.share;
            }
        }
        let total: f64 = shares.values().sum();
        let (main, share) = shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (total > MUCH_OF_A_TURN).then_some((share, total, Bound::ALL[main], *lobe, turn))
    });
    let (share, total, bound, lobe, turn) = limited.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (limit, place) = match bound {
        Bound::Limit(axis, quantity) => {
            let limits: &MotionLimits = &prepared.machine.axis(axis).limits;
            let (value, unit) = in_file(axis, quantity, quantity.limit(limits));
            let place = prepared.job.machine.place(limit_key(axis, quantity));
            (format!("the {} limit of {} ({value} {unit}, {place})", quantity.name(), axis.joint()), true)
        }
        _ => ("the power of the wheel (wheel_power)".to_owned(), false),
    };
    let remedy = if place { "lower work_speed_rpm, or raise the limit if the axis can" } else { "reduce the infeed" };
    let (pass_name, name) = (pass_name(prepared, pass), lobe_name(prepared, lobe));
    let (wanted, reached) = (turn.bounds.work_speed_rad_s(), TURN_RAD / turn.turn_s);
    let message = format!(
        "lobe {name}, pass {pass_name}: limits slow C for {:.0} % of a turn's time, {limit} for {:.0} %; C reaches {:.1} rpm in the mean, \
         work_speed_rpm allows {:.1}: {remedy}",
        100.0 * total,
        100.0 * share,
        rpm_from_rad_s(reached),
        rpm_from_rad_s(wanted)
    );
    let key = error_location::pass_key(&prepared.job, pass_name, "work_speed_rpm");
    Some(warning(prepared.job.document.error(&key, message)))
}

/// Tables whose printed figures are coarser than the infeed of a turn, in a job of many turns.
fn coarse_tables(prepared: &PreparedJob) -> Vec<Finding> {
    let job = &prepared.job;
    let coarse = |(index, lift): (usize, &camwright_files::lift_file::ProfileLift)| {
        let table = lift.table.as_ref()?;
        let lobe = job.spec.lobes.iter().position(|lobe| lobe.profile == index)?;
        let turns: u32 = prepared.planned.plan.cuts_of(lobe).map(|cut| cut.turns).sum();
        let passes = &prepared.planned.lobes.get(lobe)?.passes;
        let finest_mm =
            passes.iter().map(|pass| pass.infeed().schedule().min_per_turn_mm()).fold(f64::INFINITY, f64::min);
        let unknown_mm = table.unknown_mm();
        if turns < MANY_TURNS || unknown_mm <= finest_mm {
            return None;
        }
        let name = &job.spec.profiles[index].name;
        let message = format!(
            "profile {name}: {turns} turns with {:.3} um of infeed each are finer than the table, whose {} rows of {} mm leave {:.3} um of the \
             form open: use a finer table, or fewer turns with more infeed each",
            um_from_mm(finest_mm),
            table.blocks(),
            table.resolution_mm(),
            um_from_mm(unknown_mm)
        );
        Some(warning(job.document.error(&format!("profiles.{index}.lift"), message)))
    };
    job.lifts.iter().enumerate().filter_map(coarse).collect()
}

/// A table of few rows, which divide the infeed of a turn into few blocks, in a pass of many turns.
fn few_rows(prepared: &PreparedJob) -> Option<Finding> {
    let job = &prepared.job;
    let blocks = job.spec.blocks_per_turn;
    let divides = |lift: &camwright_files::lift_file::ProfileLift| {
        lift.table.as_ref().is_some_and(|table| u32::try_from(table.blocks()) == Ok(blocks))
    };
    let (index, _) = job.lifts.iter().enumerate().find(|(_, lift)| divides(lift))?;
    if blocks >= FORMULA_BLOCKS || job.document.root.get("blocks_per_turn").is_some() {
        return None;
    }
    let per_turn_mm = |pass: &PassSpec| f64::from(blocks) * pass.infeed_per_block_mm;
    let turns = |pass: &PassSpec| pass.total_infeed_mm / per_turn_mm(pass);
    let pass = job.spec.passes.iter().max_by(|a, b| turns(a).total_cmp(&turns(b)))?;
    let key = error_location::infeed_key(job, &pass.name);
    // The rows of the table do not matter to an infeed per turn.
    if turns(pass) < MANY_INFEED_TURNS || key.ends_with("per_turn_um") {
        return None;
    }
    let per_block_um = um_from_mm(pass.infeed_per_block_mm);
    let message = format!(
        "profile {}: the table has {blocks} rows, so a turn has {blocks} blocks, and infeed.per_block_um {per_block_um} makes {:.2} um per turn \
         and {:.0} turns in pass {}; for fewer turns raise infeed.per_block_um, or set blocks_per_turn: {FORMULA_BLOCKS}",
        job.spec.profiles[index].name,
        um_from_mm(per_turn_mm(pass)),
        turns(pass),
        pass.name
    );
    Some(warning(job.document.error(&key, message)))
}

/// Key of the machine file with a limit of an axis.
pub(super) fn limit_key(axis: Axis, quantity: LimitedQuantity) -> &'static str {
    match (axis, quantity) {
        (Axis::C, LimitedQuantity::Velocity) => "c_axis.max_speed_rpm",
        (Axis::C, LimitedQuantity::Acceleration) => "c_axis.max_acceleration_rad_s2",
        (Axis::C, LimitedQuantity::Jerk) => "c_axis.max_jerk_rad_s3",
        (Axis::X, LimitedQuantity::Velocity) => "x_axis.max_speed_mm_s",
        (Axis::X, LimitedQuantity::Acceleration) => "x_axis.max_acceleration_mm_s2",
        (Axis::X, LimitedQuantity::Jerk) => "x_axis.max_jerk_mm_s3",
        (Axis::Z, LimitedQuantity::Velocity) => "z_axis.max_speed_mm_s",
        (Axis::Z, LimitedQuantity::Acceleration) => "z_axis.max_acceleration_mm_s2",
        (Axis::Z, LimitedQuantity::Jerk) => "z_axis.max_jerk_mm_s3",
    }
}

/// Value and unit of a limit as the machine file has them.
fn in_file(axis: Axis, quantity: LimitedQuantity, value: f64) -> (f64, &'static str) {
    match (axis, quantity) {
        (Axis::C, LimitedQuantity::Velocity) => ((rpm_from_rad_s(value) * 1e6).round() / 1e6, "rpm"),
        _ => (value, quantity.unit(axis)),
    }
}
