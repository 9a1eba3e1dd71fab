// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Values of a cut, period by period, for tables and figures.

use super::PreparedJob;
use camwright::machine::description::Axis;
use camwright::math::units::{TURN_RAD, deg_from_rad};
use camwright::motion::cut_motion::CutMotion;
use camwright::planner::PlannedLobe;

/// Most rows of the cuts of a job, some 200 MB of text: beyond them only every second, third … period has a row. 1000 s at 1 ms have one each.
const MAX_ROWS: u64 = 1_000_000;

/// Periods from one row to the next.
fn stride(prepared: &PreparedJob) -> u64 {
    let cut_s: f64 = prepared.planned.lobes.iter().flat_map(|lobe| &lobe.passes).map(|pass| pass.law().end()).sum();
    let periods = cut_s * 1e9 / f64::from(prepared.machine.cycle_time_ns);
    #[allow(clippy::cast_possible_truncation, reason = "it saturates")]
    let periods = periods as u64;
    periods.div_ceil(MAX_ROWS).max(1)
}

/// A row of `speed_plan.csv`: one interpolation period of a cut.
pub(super) struct PassRow {
    pub(super) c_deg: f64,
    /// Since the start of the pass.
    pub(super) t_s: f64,
    pub(super) c: [f64; 3],
    pub(super) x: [f64; 3],
    pub(super) removal_mm2_s: f64,
}

/// A pass over a lobe, at every interpolation period from its start to its end, lead-in and lead-out included; of jobs of more than
/// [`MAX_ROWS`] periods at even steps of them.
pub(super) fn pass_rows<'a>(
    prepared: &'a PreparedJob,
    index: usize,
    lobe: &'a PlannedLobe,
    pass: usize,
) -> impl Iterator<Item = PassRow> + 'a {
    let cycle_ns = u64::from(prepared.machine.cycle_time_ns);
    let sense = f64::from(prepared.machine.rotation_sense);
    let stride = usize::try_from(stride(prepared)).unwrap_or(usize::MAX);
    let plan = &prepared.planned.plan;
    let scale = prepared.machine.axis(Axis::C).scale;
    let cut = plan
        .cuts_of(index)
        .nth(pass)
        .and_then(|cut| Some((plan.motion_of(cut)?, cut.turns, scale.position(cut.start_counts))));
    cut.into_iter().flat_map(move |(motion, turns, start_rad)| {
        // Before the first turn the blank stands there, later what the pass before has left.
        let blank_mm = prepared.job.spec.stock_mm;
        let before_mm = if pass == 0 { blank_mm } else { blank_mm.min(motion.infeed.sample(0.0).value) };
        let (start_s, end_s) = (motion.start_s(), motion.end_s());
        let turns_rad = f64::from(turns) * TURN_RAD;
        #[allow(clippy::cast_possible_truncation, reason = "the duration of a cut is positive")]
        let last = ((end_s - start_s) * 1e9 / cycle_ns as f64).ceil() as u64;
        (0..=last).step_by(stride).map(move |tick| {
            // Whole nanoseconds first, so that tick 3 of a millisecond is 0.003 and not 0.0030000000000000001.
            let t_s = (tick * cycle_ns) as f64 / 1e9;
            let sample = motion.at((start_s + t_s).min(end_s));
            let angle = sample.c.value;
            // On the way to the part and from it, with C turning on, nothing is cut.
            let on_part = (0.0..=turns_rad).contains(&angle);
            PassRow {
                c_deg: deg_from_rad(start_rad + sample.c.value),
                t_s,
                c: [sample.c.first, sample.c.second, sample.c.third],
                x: [sample.x.first, sample.x.second, sample.x.third],
                removal_mm2_s: if on_part {
                    removal_mm2_s(&motion, lobe, sense, before_mm, angle, sample.c.first)
                } else {
                    0.0
                },
            }
        })
    })
}

/// Specific removal rate Q'w (mm³ per mm of width and s): depth of cut along the normal times the speed of the footprint
/// along the contour, `|W|·Ċ/(cos β·(1 + κR))`.
///
/// What stands above the contour at the wheel is what the wheel left there one turn ago, RT less the infeed until then,
/// seen along the normal (cos β), and never more than the stock of the blank.
fn removal_mm2_s(
    motion: &CutMotion<'_>,
    lobe: &PlannedLobe,
    sense: f64,
    before_mm: f64,
    angle: f64,
    speed: f64,
) -> f64 {
    let theta = sense * (motion.path_start_rad + angle);
    let along_normal = lobe.tool_path.beta(theta).cos();
    let offset = |angle: f64| motion.offset_over_angle(angle).value * along_normal;
    let before = if angle < TURN_RAD { before_mm } else { before_mm.min(offset(angle - TURN_RAD)) };
    let depth = (before - offset(angle)).max(0.0);
    depth * lobe.tool_path.footprint_speed_ratio_mm(theta) * speed
}
