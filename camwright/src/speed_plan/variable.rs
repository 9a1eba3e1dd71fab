//! A cut at varying speed: a run-up onto the fastest turn, that turn over and over again, a run-down from it.

use super::process::{Cutting, largest_speed_rad_s};
use super::turn_speed::TurnSpeed;
use super::{Candidate, Misfit, PATH_SHARE, SpeedRequest, TurnRequest, windows};
use crate::cut_motion::chain;
use crate::infeed::BLEND_SHARE;
use crate::machine::description::MotionLimits;
use crate::numeric::hermite::{HermiteSpline, Knot, Sample, quintic};
use crate::units::TURN_RAD;
use alloc::vec::Vec;

/// Points at which a ramp is looked at: few to see that it does not fit, many to see that it does.
const RAMP_POINTS: [u32; 2] = [24, 400];

/// How long a ramp may take, in times of its angle at its final speed; a run-up at constant acceleration takes 2.
const RAMP_FACTORS: [f64; 12] = [1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1, 2.2, 2.4, 2.6, 2.8, 3.2];

/// Knots of the turn tried beyond the first that a ramp can meet: a later one may cost less time.
const MORE_KNOTS: usize = 40;

/// Share of what a path may use that a ramp aims at, so that the finer check passes.
const RAMP_SHARE: f64 = 0.98;

/// How often a turn is slowed down after the check of the whole cut, each time by what was found.
const CORRECTIONS: u32 = 5;

impl SpeedRequest<'_> {
    /// X over the path angle, with the infeed's slope or without.
    fn over_path(&self, angle_rad: f64, with_infeed: bool) -> Sample {
        let mut x = self.path.sample(angle_rad);
        if with_infeed {
            x.first -= self.infeed.lasting_slope_mm_rad();
        }
        x
    }

    fn cutting(&self) -> Cutting {
        Cutting {
            wheel_radius_mm: self.wheel_radius_mm,
            wheel_speed_m_s: self.wheel_speed_m_s,
            infeed_per_turn_mm: self.infeed.slope_mm_rad() * TURN_RAD,
            infeed_direction: self.infeed_direction,
        }
    }

    /// What the process allows at a path angle (rad/s).
    fn process_rad_s(&self, angle_rad: f64) -> f64 {
        largest_speed_rad_s(&self.speed, self.path.sample(angle_rad), &self.cutting())
    }
}

/// The fastest cut under the law of the request.
pub(super) fn variable_speed(request: &SpeedRequest<'_>) -> Result<(Candidate, TurnSpeed), Misfit> {
    let bound = |angle: f64| request.process_rad_s(angle);
    let mut turn = TurnSpeed::fastest(&TurnRequest {
        path: request.path,
        infeed_slope_mm_rad: -request.infeed.lasting_slope_mm_rad(),
        bound: &bound,
        c: request.c.with_share(PATH_SHARE),
        // The end of the infeed takes its share of what X may use.
        x: request.x.with_share(PATH_SHARE - BLEND_SHARE),
    })
    .map_err(Misfit::Turn)?;
    let mut misfit = Misfit::NoRunUp;
    for _ in 0..CORRECTIONS {
        let candidate = around(request, &turn)?;
        let worst = candidate.uses.iter().copied().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        match worst {
            Some(worst) if worst.ratio() > 1.0 => {
                turn = turn.slower(worst.ratio() * (1.0 + 1e-9));
                misfit = Misfit::Limit(worst);
            }
            _ => return Ok((candidate, turn)),
        }
    }
    Err(misfit)
}

/// Ramps and turns put together, and how they use the limits.
fn around(request: &SpeedRequest<'_>, turn: &TurnSpeed) -> Result<Candidate, Misfit> {
    let total = f64::from(request.turns()) * TURN_RAD;
    let knots = turn.knots(request.path_start_rad, 0.0, total);
    let (_, fastest) = turn.range_rad_s();
    let infeed = request.infeed_for(fastest);
    let along = |angle: f64, backwards: bool| {
        let at = request.path_start_rad + if backwards { total - angle } else { angle };
        let mut x = request.over_path(at, !backwards);
        if backwards {
            (x.first, x.third) = (-x.first, -x.third);
        }
        (x, request.process_rad_s(at))
    };
    let reversed: Vec<Knot> = knots
        .iter()
        .rev()
        .map(|knot| Knot { at: -knot.at, value: total - knot.value, first: knot.first, second: -knot.second })
        .collect();
    let up = run_up(&knots, request, |angle| along(angle, false)).ok_or(Misfit::NoRunUp)?;
    let down = run_up(&reversed, request, |angle| along(angle, true)).ok_or(Misfit::NoRunUp)?;
    let last = knots.len() - 1 - down.knot;
    // Less than a turn of plateau could not be previewed, nor a turn put in.
    if last <= up.knot || knots[last].value - knots[up.knot].value < TURN_RAD {
        let plateau = knots.get(last).map_or(0.0, |knot| knot.value - knots[up.knot].value);
        return Err(Misfit::NoPlateau(total - plateau));
    }
    let shift = up.time_s - knots[up.knot].at;
    let mut law = Vec::with_capacity(last - up.knot + 3);
    law.push(Knot { at: 0.0, value: 0.0, first: 0.0, second: 0.0 });
    law.extend(knots[up.knot..=last].iter().map(|knot| Knot { at: knot.at + shift, ..*knot }));
    let plateau_s = (up.time_s, knots[last].at + shift);
    law.push(Knot { at: plateau_s.1 + down.time_s, value: total, first: 0.0, second: 0.0 });
    let law = HermiteSpline::new(law).map_err(|_| Misfit::NoRunUp)?;
    let mut candidate = Candidate { law, infeed, plateau_s, turn_s: turn.turn_s(), uses: Vec::new() };
    let motion = request.motion(&candidate);
    let stretches = windows(&motion, plateau_s, candidate.turn_s, candidate.infeed.last_blend_rad());
    let uses = super::uses_by_chain_rule(&motion, &stretches, request.step(candidate.turn_s), &request.c, &request.x);
    candidate.uses = request.seen_from_lobe(uses);
    Ok(candidate)
}

/// A run-up from rest: onto which knot, and how long it takes.
struct RunUp {
    knot: usize,
    time_s: f64,
}

/// The run-up that loses least time: one quintic in time from rest onto a knot of the turn, with its speed and acceleration.
/// `along` gives X and the speed that the process allows over the angle since the start.
fn run_up(knots: &[Knot], request: &SpeedRequest<'_>, along: impl Fn(f64) -> (Sample, f64)) -> Option<RunUp> {
    let c = request.c.with_share(RAMP_SHARE * PATH_SHARE);
    let x = request.x.with_share(RAMP_SHARE * PATH_SHARE);
    let rest = Knot { at: 0.0, value: 0.0, first: 0.0, second: 0.0 };
    let keeps = |to: &Knot, points: u32| {
        (0..=points).all(|i| {
            let angle = quintic(&rest, to, to.at * f64::from(i) / f64::from(points));
            let (over_angle, allowed) = along(angle.value);
            let moved = chain(over_angle, angle);
            let is_within = |sample: Sample, limits: &MotionLimits| {
                sample.first.abs() <= limits.velocity
                    && sample.second.abs() <= limits.acceleration
                    && sample.third.abs() <= limits.jerk
            };
            angle.first >= -1e-9 && angle.first <= allowed && is_within(angle, &c) && is_within(moved, &x)
        })
    };
    let mut best: Option<(RunUp, f64)> = None;
    let mut left = usize::MAX;
    for (knot, target) in knots.iter().enumerate().filter(|(_, knot)| knot.value > 1e-6) {
        if target.value > TURN_RAD || left == 0 {
            break;
        }
        left = left.saturating_sub(1);
        for factor in RAMP_FACTORS {
            let time_s = factor * target.value / target.first;
            // Time lost against being at speed from the start.
            let lost = time_s - (target.at - knots[0].at);
            let to = Knot { at: time_s, ..*target };
            let is_worse = best.as_ref().is_some_and(|(_, least)| lost >= *least);
            if is_worse || !RAMP_POINTS.into_iter().all(|points| keeps(&to, points)) {
                continue;
            }
            if best.is_none() {
                left = MORE_KNOTS;
            }
            best = Some((RunUp { knot, time_s }, lost));
        }
    }
    best.map(|(run_up, _)| run_up)
}
