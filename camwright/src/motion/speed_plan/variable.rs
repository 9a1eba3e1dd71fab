// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cut at varying speed: a run-up onto the fastest turn, that turn over and over again, a run-down from it.

use super::process::{Cutting, largest_speed_rad_s};
use super::run_up::run_up;
use super::square_speed::to_f64;
use super::turn_speed::TurnSpeed;
use super::{
    Candidate, LimitUse, LimitViolation, LimitedQuantity, MAX_CUT_S, MAX_LAW_KNOTS, PATH_SHARE, PLANNING_GRID,
    SpeedRequest, TurnRequest, VARYING_X_SHARE, windows,
};
use crate::math::hermite::{HermiteSpline, Knot, Sample};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Maximum number of corrections after the check of the whole cut: each slows the turn or makes its ramps gentler by the excess found.
const CORRECTIONS: u32 = 5;

/// Additional reduction of a ramp's limits after an excess.
const RAMP_STEP: f64 = 0.995;

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

    /// Speed allowed by the process and the wheel's power at a position of the path (rad/s).
    fn process_rad_s(&self, path: Sample) -> f64 {
        let cutting = self.cutting();
        let by_power = self.wheel_power.map_or(f64::INFINITY, |power| largest_speed_rad_s(&power, path, &cutting));
        largest_speed_rad_s(&self.speed, path, &cutting).min(by_power)
    }

    /// The least that the wheel's power allows over a turn (rad/s), and the path angle where.
    pub(super) fn minimum_by_power(&self) -> Option<(f64, f64)> {
        let (power, cutting) = (self.wheel_power?, self.cutting());
        let parts = u32::try_from(PLANNING_GRID.div_ceil(self.path.coefficients().len())).unwrap_or(1);
        let samples = self.path.samples(parts);
        let spacing = TURN_RAD / to_f64(samples.len());
        let allowed = |path: &Sample| largest_speed_rad_s(&power, *path, &cutting);
        let (index, min) =
            samples.iter().map(allowed).enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY));
        Some((min, to_f64(index) * spacing))
    }
}

/// The fastest cut under the law of the request.
pub(super) fn variable_speed(request: &SpeedRequest<'_>) -> Result<(Candidate, TurnSpeed), LimitViolation> {
    let bound = |_: f64, path: Sample| request.process_rad_s(path);
    let mut turn = TurnSpeed::fastest(&TurnRequest {
        path: request.path,
        infeed_slope_mm_rad: -request.infeed.lasting_slope_mm_rad(),
        bound: &bound,
        c: request.c.with_share(PATH_SHARE),
        x: request.x.with_share(VARYING_X_SHARE),
    })
    .map_err(LimitViolation::Turn)?;
    let mut misfit = LimitViolation::NoRunUp;
    let mut ramp_share = 1.0;
    for _ in 0..CORRECTIONS {
        let candidate = around(request, &turn, ramp_share)?;
        let worst = candidate.uses.iter().copied().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        match worst {
            Some(worst) if worst.ratio() > 1.0 => {
                if worst.time_s < candidate.plateau_s.0 || worst.time_s > candidate.plateau_s.1 {
                    ramp_share *= RAMP_STEP / worst.ratio();
                } else {
                    turn = turn.slower(worst.ratio() * (1.0 + 1e-9));
                }
                misfit = LimitViolation::Limit(worst);
            }
            // The knots of a short ramp lie closer than the points of the planning grid, and its jerk may peak between these.
            _ => match exceeded_on_ramps(request, &candidate) {
                Some(exceeded) => {
                    ramp_share *= RAMP_STEP / exceeded.ratio();
                    misfit = LimitViolation::Limit(exceeded);
                }
                None => return Ok((candidate, turn)),
            },
        }
    }
    Err(misfit)
}

/// Finds the acceleration or jerk that exceeds its limit most on a ramp, by differencing positions as the check of the whole cut does.
fn exceeded_on_ramps(request: &SpeedRequest<'_>, candidate: &Candidate) -> Option<LimitUse> {
    let motion = request.motion(candidate);
    // Where C comes or goes turning, the way of X onto the path is added later.
    let up = request.comes.is_none().then(|| (motion.start_s(), candidate.plateau_s.0));
    let down = request.goes.is_none().then(|| (candidate.plateau_s.1, motion.end_s()));
    let ramps: Vec<(f64, f64)> = up.into_iter().chain(down).collect();
    let step = request.check_step(candidate.turn_s);
    let uses = request.seen_from_lobe(super::uses_by_differences(&motion, &ramps, step, &request.c, &request.x));
    let exceeded = uses.into_iter().filter(|found| found.quantity != LimitedQuantity::Velocity && found.ratio() > 1.0);
    exceeded.max_by(|a, b| a.ratio().total_cmp(&b.ratio()))
}

/// Ramps and turns put together, and how they use the limits.
fn around(request: &SpeedRequest<'_>, turn: &TurnSpeed, ramp_share: f64) -> Result<Candidate, LimitViolation> {
    let (turns, total) = (f64::from(request.turns()), f64::from(request.turns()) * TURN_RAD);
    let cut_s = turns * turn.turn_s();
    if cut_s.is_nan() || cut_s > MAX_CUT_S {
        return Err(LimitViolation::TooLong(cut_s));
    }
    let count = turns * to_f64(turn.knots_of_turn());
    if count > MAX_LAW_KNOTS {
        return Err(LimitViolation::TooManyKnots(count));
    }
    let knots = turn.knots(request.path_start_rad, 0.0, total);
    let (_, fastest) = turn.range_rad_s();
    let infeed = request.infeed_for(fastest);
    let (comes_rad_s, goes_rad_s) = request.end_speeds_rad_s();
    let along = |angle: f64, backwards: bool| {
        let at = request.path_start_rad + if backwards { total - angle } else { angle };
        let mut x = request.over_path(at, !backwards);
        if backwards {
            (x.first, x.third) = (-x.first, -x.third);
        }
        (x, request.process_rad_s(request.path.sample(at)))
    };
    let reversed: Vec<Knot> = knots
        .iter()
        .rev()
        .map(|knot| Knot { at: -knot.at, value: total - knot.value, first: knot.first, second: -knot.second })
        .collect();
    let (c, x) = (request.c.with_share(ramp_share * PATH_SHARE), request.x.with_share(ramp_share * PATH_SHARE));
    let up = run_up(&knots, comes_rad_s, c, x, |angle| along(angle, false)).ok_or(LimitViolation::NoRunUp)?;
    let down = run_up(&reversed, goes_rad_s, c, x, |angle| along(angle, true)).ok_or(LimitViolation::NoRunUp)?;
    let last = knots.len() - 1 - down.knot;
    // Less than a turn of plateau could not be previewed, nor a turn put in.
    if last <= up.knot || knots[last].value - knots[up.knot].value < TURN_RAD {
        let plateau = knots.get(last).map_or(0.0, |knot| knot.value - knots[up.knot].value);
        return Err(LimitViolation::NoPlateau(total - plateau));
    }
    let shift = up.time_s - knots[up.knot].at;
    let mut law = Vec::with_capacity(last - up.knot + 1 + up.way.len() + down.way.len());
    law.extend_from_slice(&up.way);
    law.extend(knots[up.knot..=last].iter().map(|knot| Knot { at: knot.at + shift, ..*knot }));
    let plateau_s = (up.time_s, knots[last].at + shift);
    let end_s = plateau_s.1 + down.time_s;
    law.extend(down.way.iter().rev().map(|knot| Knot {
        at: end_s - knot.at,
        value: total - knot.value,
        first: knot.first,
        second: -knot.second,
    }));
    let law = HermiteSpline::new(law).map_err(|_| LimitViolation::NoRunUp)?;
    let mut candidate = Candidate { law, infeed, lead: None, plateau_s, turn_s: turn.turn_s(), uses: Vec::new() };
    let motion = request.motion(&candidate);
    let stretches = windows(&motion, plateau_s, candidate.turn_s, candidate.infeed.varies_rad());
    let uses = super::uses_by_chain_rule(&motion, &stretches, request.step(candidate.turn_s), &request.c, &request.x);
    candidate.uses = request.seen_from_lobe(uses);
    Ok(candidate)
}
