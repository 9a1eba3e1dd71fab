// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Comparison of a program that was read back with the paths it was made for.

use super::turn::SubprogramMotion;
use super::{PostError, PostRequest, PostedProgram};
use crate::gcode::NcAxis;
use crate::gcode::archimedean::{Chain, ChainDeviation, ChainRequest, Knots, Travelling};
use crate::math::units::um_from_mm;
use crate::toolpath::cutter_path::CarriageAxis;
use alloc::vec::Vec;

/// A motion of a program, from any reader.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramRun {
    /// X, Y, Z (mm) and C (rad) at the end, in the part's frame.
    pub pose: [f64; 4],
    /// Duration (s); `None` for a rapid.
    pub time_s: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProgramComparison {
    pub moves: usize,
    /// Calls, each a run of feeds between rapids.
    pub calls: usize,
    /// Largest distance along an axis from the path at what is left of the depth (mm).
    pub error_mm: f64,
    /// Largest share of its tolerance that a call is off; 1 is all of it.
    pub share_of_tolerance: f64,
    /// That call, from 0.
    pub worst_call: usize,
    /// The part's angle there (rad).
    pub worst_at_rad: f64,
    /// Largest difference of a call's time from what was meant (s).
    pub time_error_s: f64,
    /// Time of all feeds (s).
    pub feed_time_s: f64,
}

impl ProgramComparison {
    /// Adds a run of feeds: the call or pass with this index, its judged deviation from the path, its tolerance and its time in the plan.
    pub(super) fn add(
        &mut self,
        index: usize,
        run: &[ProgramRun],
        judged: &[ChainDeviation],
        tolerance_mm: f64,
        planned_s: f64,
    ) {
        for judged in judged {
            let share = judged.error_mm / tolerance_mm;
            if share > self.share_of_tolerance || share.is_nan() {
                (self.share_of_tolerance, self.worst_call) = (share, index);
                self.worst_at_rad = judged.error_at_rad;
            }
            self.error_mm = self.error_mm.max(judged.error_mm);
        }
        let time_s: f64 = run.iter().skip(1).filter_map(|ran| ran.time_s).sum();
        self.feed_time_s += time_s;
        self.time_error_s = self.time_error_s.max((time_s - planned_s).abs());
    }
}

/// Compares motions with what was posted: every run of feeds is a call, in the order of the calls.
///
/// # Errors
/// Another number of runs than of calls; a rapid that moves C, or an axis beside the infeed, while the cutter is not clear.
pub fn compare(
    request: &PostRequest<'_>,
    posted: &PostedProgram,
    moves: &[ProgramRun],
) -> Result<ProgramComparison, PostError> {
    let runs = runs(moves);
    if runs.len() != posted.calls.len() {
        return Err(PostError::OtherCalls { found: runs.len(), expected: posted.calls.len() });
    }
    let mut compared = ProgramComparison { moves: moves.len(), calls: runs.len(), ..ProgramComparison::default() };
    for (index, (run, (turn, phase_rad, leaves_mm))) in runs.iter().zip(&posted.calls).enumerate() {
        let posted_turn = &posted.turns[*turn];
        let of = &request.features[posted_turn.feature];
        let pass = &of.passes[posted_turn.pass];
        let ideal = SubprogramMotion::new(&request.control, of, pass);
        let axes: Vec<CarriageAxis> = ideal.axes();
        let position = |axis: &CarriageAxis| -> Vec<f64> {
            let left_mm = if *axis == of.path.infeed { *leaves_mm } else { 0.0 };
            run.iter().map(|ran| ran.pose[NcAxis::from(*axis).index()] - left_mm).collect()
        };
        let chain = Chain {
            angles_rad: run.iter().map(|ran| ran.pose[NcAxis::C.index()] - phase_rad).collect(),
            positions_mm: axes.iter().map(position).collect(),
        };
        let ideal = &ideal;
        let travels: Vec<_> = axes.iter().map(|axis| move |u_rad: f64| ideal.at(*axis, u_rad)).collect();
        let travels: Vec<Travelling<'_>> = travels.iter().map(|travel| travel as Travelling<'_>).collect();
        let (Some(from), Some(to)) = (ideal.stretches().first().copied(), ideal.stretches().last().copied()) else {
            continue;
        };
        let judged = chain.judge(&ChainRequest {
            travels: &travels,
            from_rad: from.0,
            to_rad: to.1,
            tolerance_mm: posted_turn.tolerance_mm,
            rounding_mm: 0.0,
            knots: Knots::OnCurve,
        })?;
        compared.add(index, run, &[judged], posted_turn.tolerance_mm, posted_turn.time_s);
    }
    check_rapids(request, posted, moves)?;
    Ok(compared)
}

/// Runs of feeds, each with the pose from which it begins.
pub(super) fn runs(moves: &[ProgramRun]) -> Vec<&[ProgramRun]> {
    let mut runs = Vec::new();
    let mut from = None;
    for (index, ran) in moves.iter().enumerate() {
        match (ran.time_s.is_some(), from) {
            (true, None) => from = Some(index.saturating_sub(1)),
            (false, Some(start)) => {
                runs.push(&moves[start..index]);
                from = None;
            }
            _ => {}
        }
    }
    if let Some(start) = from {
        runs.push(&moves[start..]);
    }
    runs
}

/// Rapids in which anything but the infeed axis moves must be clear of the part.
fn check_rapids(request: &PostRequest<'_>, posted: &PostedProgram, moves: &[ProgramRun]) -> Result<(), PostError> {
    /// Rounding of what is read.
    const SAME: f64 = 1e-3;
    let mut call = 0;
    let mut feeding = false;
    for pair in moves.windows(2) {
        let [from, to] = pair else { continue };
        if to.time_s.is_some() {
            feeding = true;
            continue;
        }
        if feeding {
            call += 1;
            feeding = false;
        }
        let Some((turn, ..)) = posted.calls.get(call).or(posted.calls.last()) else { continue };
        let of = &request.features[posted.turns[*turn].feature];
        let infeed = NcAxis::from(of.path.infeed).index();
        let others = (0..4).filter(|axis| *axis != infeed);
        let moves_beside = others.into_iter().any(|axis| (to.pose[axis] - from.pose[axis]).abs() > SAME);
        // An axis that was nowhere yet is not compared.
        let clear = !from.pose[infeed].is_finite() || from.pose[infeed].min(to.pose[infeed]) > of.clear_mm - SAME;
        if moves_beside && !clear {
            return Err(PostError::RapidNotClear {
                feature: of.name.clone(),
                at_mm: from.pose[infeed].min(to.pose[infeed]),
                clear_mm: of.clear_mm,
            });
        }
    }
    Ok(())
}

impl ProgramComparison {
    /// Largest distance from the path (µm).
    #[must_use]
    pub fn error_um(&self) -> f64 {
        um_from_mm(self.error_mm)
    }
}
