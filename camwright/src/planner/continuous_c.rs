// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! C turns on from lobe to lobe: the phase with which it arrives at the next lobe is predicted, and the cut begins there.
//!
//! ```text
//!  C   ___cut___ lead-out |  table to the next station  | waits | lead-in ___cut___
//!   turning all the time  |<------ predicted ticks ---->|       |
//!                                                       '- here C arrives with the predicted phase
//! ```
//!
//! The next lead-in begins a margin after the predicted arrival. A table that finds its switch later than that misses the phase,
//! and the cut begins a turn later; nothing else changes.

use super::error::PlanError;
use super::lobe::{LobePlanner, LobeStart, PlannedLobe, extremes, infeed_of_x_mm};
use super::sequence::Sequence;
use crate::job::dressing::Dress;
use crate::machine::description::Axis;
use crate::math::units::TURN_RAD;
use crate::motion::point_to_point::whole_ticks;
use crate::motion::speed_change::change_of_speed;
use crate::motion::speed_plan::{FlyingStart, SpeedPlan, largest_lead_speed_rad_s, shortest_lead_s};
use alloc::vec::Vec;

/// Speeds of C between lobes that are tried, as shares of the cut's own where it begins and ends: the first that ramps and leads
/// fit to is taken.
const SPEED_SHARES: [f64; 9] = [1.0, 0.85, 0.7, 0.55, 0.4, 0.28, 0.18, 0.1, 0.05];

/// Rounds in which the phase of arrival is looked for: it decides the speed and the length of the lead-in, and they decide it.
const ROUNDS: u32 = 12;

/// Phases from which it is looked for, over a turn.
const PHASES: u32 = 8;

/// C at the end of a cut from which it turns on.
#[derive(Debug, Clone, Copy)]
struct Departure {
    c_rad: f64,
    speed_rad_s: f64,
    /// Predicted ticks of the plan up to there.
    ticks: u64,
}

/// State at the start of a cut that C enters while turning.
#[derive(Debug, Clone, Copy)]
struct CutArrival {
    begin: LobeStart,
    turning: FlyingStart,
    /// From the predicted arrival to the beginning of the lead-in (s).
    waits_s: f64,
    lead_s: f64,
}

/// Position of X between the lobes (mm): clear of the highest lobe by the retract distance, on a count.
pub(super) fn clear_x_mm(planner: &LobePlanner<'_>, stopping: &[PlannedLobe]) -> f64 {
    let reach_mm = |lobe: &PlannedLobe| {
        let (_, highest_mm) = extremes(lobe.tool_path.spline());
        let infeed_mm = infeed_of_x_mm(planner.job, &lobe.tool_path, lobe.start_rad, planner.total_infeed_mm());
        highest_mm + planner.job.maximum_stock_mm().max(infeed_mm)
    };
    let clear_mm = stopping.iter().map(reach_mm).fold(0.0, f64::max) + planner.job.retract_clearance_mm;
    let scale = planner.machine.axis(Axis::X).scale;
    scale.position(scale.counts(clear_mm))
}

/// Plans every lobe from the angle at which C arrives, with its steps. `stopping` are the same lobes with C stopping in between,
/// the first from `begin`; their turns give the speed of C.
pub(super) fn grind_turning(
    planner: &LobePlanner<'_>,
    sequence: &mut Sequence<'_>,
    stopping: &[PlannedLobe],
    begins: &[LobeStart],
    dresses: &[Dress],
    margin_s: f64,
) -> Result<Vec<PlannedLobe>, PlanError> {
    let clear_x_mm = clear_x_mm(planner, stopping);
    let cycle_s = planner.machine.cycle_time_s();
    let mut lobes = Vec::with_capacity(stopping.len());
    let mut departure: Option<Departure> = None;
    for index in 0..stopping.len() {
        for dress in dresses.iter().filter(|dress| dress.before_lobe == index) {
            sequence.dress(dress, &stopping[index].design.name)?;
        }
        sequence.index_to(index)?;
        let between =
            LobeTransitions { planner, index, stopping: &stopping[index], stopping_begin: begins[index], clear_x_mm };
        let goes_on = index + 1 < stopping.len();
        let (lobe, begin, waits_ticks) = match departure {
            None if !goes_on => (stopping[index].clone(), begins[index], 0),
            None => (between.leaving_from_rest(begins[index])?, begins[index], 0),
            Some(departure) => {
                sequence.stand_clear(index, clear_x_mm)?;
                let away_s = (sequence.ticks() - departure.ticks) as f64 * cycle_s;
                let (lobe, arrival) = between.arriving(&departure, away_s + margin_s, goes_on)?;
                (lobe, arrival.begin, whole_ticks(margin_s + arrival.waits_s, cycle_s))
            }
        };
        sequence.grind(index, &lobe, begin, waits_ticks)?;
        departure = lobe.passes.last().filter(|_| goes_on).map(|last| {
            let end = last.law().knots()[last.law().knots().len() - 1];
            // Passes before the last one turn C by whole turns.
            let whole: u32 = lobe.passes.iter().rev().skip(1).map(SpeedPlan::turns).sum();
            let begin_rad = planner.machine.axis(Axis::C).scale.position(begin.c_counts);
            let c_rad = begin_rad + f64::from(whole) * TURN_RAD + end.value;
            Departure { c_rad, speed_rad_s: end.first, ticks: sequence.ticks() }
        });
        lobes.push(lobe);
    }
    Ok(lobes)
}

/// One lobe and the ways of C to it and from it.
struct LobeTransitions<'a> {
    planner: &'a LobePlanner<'a>,
    index: usize,
    stopping: &'a PlannedLobe,
    stopping_begin: LobeStart,
    clear_x_mm: f64,
}

impl LobeTransitions<'_> {
    /// C turning with a share of the speed that a pass has at a path angle (rad).
    fn turning(&self, pass: &SpeedPlan, path_rad: f64, share: f64) -> FlyingStart {
        let planner = self.planner;
        let path = &planner.shapes[self.stopping.path].path;
        let in_turn_rad_s = pass.speed_in_turn_rad_s(path_rad - self.stopping_begin.path_rad);
        let max_rad_s = largest_lead_speed_rad_s(path, &planner.machine.axis(Axis::X).limits);
        FlyingStart {
            speed_rad_s: share * in_turn_rad_s.min(max_rad_s),
            clear_x_mm: self.clear_x_mm,
            rapid_mm_s: planner.job.rapid_speed_mm_s,
        }
    }

    fn comes(&self, path_rad: f64, share: f64) -> FlyingStart {
        self.turning(&self.stopping.passes[0], path_rad, share)
    }

    fn goes(&self, path_rad: f64, share: f64) -> FlyingStart {
        self.turning(&self.stopping.passes[self.stopping.passes.len() - 1], path_rad, share)
    }

    /// From rest at a place to turning on.
    fn leaving_from_rest(&self, begin: LobeStart) -> Result<PlannedLobe, PlanError> {
        let mut last = None;
        for share in SPEED_SHARES {
            match self.planner.lobe(self.index, begin, None, Some(self.goes(begin.path_rad, share))) {
                Ok(lobe) => return Ok(lobe),
                Err(error) => last = Some(error),
            }
        }
        Err(last.expect("several speeds were tried"))
    }

    /// From where C is after a time (s) to rest or to turning on.
    fn arriving(
        &self,
        departure: &Departure,
        away_s: f64,
        goes_on: bool,
    ) -> Result<(PlannedLobe, CutArrival), PlanError> {
        let mut last = None;
        for share in SPEED_SHARES {
            let Some(arrival) = self.arrival(departure, away_s, share) else { continue };
            let goes = goes_on.then(|| self.goes(arrival.begin.path_rad, share));
            match self.planner.lobe(self.index, arrival.begin, Some(arrival.turning), goes) {
                Ok(lobe) => return Ok((lobe, arrival)),
                Err(error) => last = Some(error),
            }
        }
        Err(last.unwrap_or_else(|| PlanError::NoArrival {
            lobe: self.stopping.design.name.clone(),
            clear_x_mm: self.clear_x_mm,
        }))
    }

    /// The phase at which the cut can begin soonest, after C has turned on for a time (s).
    fn arrival(&self, departure: &Departure, away_s: f64, share: f64) -> Option<CutArrival> {
        let soonest = |best: Option<CutArrival>, found: CutArrival| match best {
            Some(best) if best.waits_s + best.lead_s <= found.waits_s + found.lead_s => Some(best),
            _ => Some(found),
        };
        (0..PHASES)
            .flat_map(|phase| {
                self.arrivals_from(departure, away_s, share, f64::from(phase) * TURN_RAD / f64::from(PHASES))
            })
            .fold(None, soonest)
    }

    /// Phases at which the cut can begin, each nearer to the arrival than the one before, from the first `ahead_rad` after it on.
    fn arrivals_from(&self, departure: &Departure, away_s: f64, share: f64, ahead_rad: f64) -> Vec<CutArrival> {
        let (machine, path) = (self.planner.machine, &self.planner.shapes[self.stopping.path].path);
        let (c, x) = (machine.axis(Axis::C), machine.axis(Axis::X));
        let mut found = Vec::new();
        let mut c_rad = departure.c_rad + departure.speed_rad_s * away_s + ahead_rad;
        for _ in 0..ROUNDS {
            let begin = self.planner.begin(self.index, c.scale.counts(c_rad));
            let turning = self.comes(begin.path_rad, share);
            let change = change_of_speed(departure.speed_rad_s, turning.speed_rad_s, &c.limits);
            let (w, total_mm) = (turning.speed_rad_s, self.planner.total_infeed_mm());
            let Some(lead_s) = shortest_lead_s(path, begin.path_rad, total_mm, &turning, &x.limits) else { break };
            // C must have come to its speed, too.
            let here_s = away_s.max(change.duration());
            let slack_rad =
                c.scale.position(begin.c_counts) - w * lead_s - (departure.c_rad + change.sample(here_s).value);
            if slack_rad >= 0.0 {
                found.push(CutArrival { begin, turning, waits_s: here_s - away_s + slack_rad / w, lead_s });
                if slack_rad < w * machine.cycle_time_s() {
                    break;
                }
            }
            // A little less than all of it, so as to stay behind the arrival once there.
            c_rad -= if slack_rad > 0.0 { 0.98 * slack_rad } else { 1.02 * slack_rad };
        }
        found
    }
}
