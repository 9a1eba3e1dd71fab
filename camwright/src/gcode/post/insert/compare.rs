// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Comparison of the program of a turned part, as it was read back, with the paths it was made for.

use super::spiral::InsertMotion;
use super::{InsertPostRequest, PostedInsertProgram};
use crate::gcode::NcAxis;
use crate::gcode::archimedean::Chain;
use crate::gcode::post::PostError;
use crate::gcode::post::compare::{ProgramComparison, ProgramRun, runs};
use alloc::vec::Vec;

/// Rounding of a position that was read (mm or rad).
const SAME: f64 = 1e-3;

/// Compares motions with the posted program: every run of feeds is a pass.
///
/// # Errors
/// Another number of runs than of passes; a run that begins or ends beside its path; a rapid of C or Z while the insert is not clear.
pub fn compare_insert(
    request: &InsertPostRequest<'_>,
    posted: &PostedInsertProgram,
    moves: &[ProgramRun],
) -> Result<ProgramComparison, PostError> {
    let runs = runs(moves);
    if runs.len() != posted.passes.len() {
        return Err(PostError::OtherCalls { found: runs.len(), expected: posted.passes.len() });
    }
    let sense = f64::from(request.control.rotation_sense);
    let mut compared = ProgramComparison { moves: moves.len(), calls: runs.len(), ..ProgramComparison::default() };
    for (index, (run, (pass, posted_pass))) in runs.iter().zip(request.passes.iter().zip(&posted.passes)).enumerate() {
        let motion = InsertMotion::new(pass);
        let position = |axis: NcAxis, shift_mm: f64| run.iter().map(move |ran| ran.pose[axis.index()] - shift_mm);
        let chain = Chain {
            angles_rad: run.iter().map(|ran| sense * ran.pose[NcAxis::C.index()] - posted_pass.c_shift_rad).collect(),
            positions_mm: alloc::vec![
                position(NcAxis::X, request.x_shift_mm).collect(),
                position(NcAxis::Z, 0.0).collect(),
            ],
        };
        let (from_rad, to_rad) = motion.range();
        let (Some(begins), Some(ends)) = (chain.angles_rad.first(), chain.angles_rad.last()) else { continue };
        if (begins - from_rad).abs() > SAME || (ends - to_rad).abs() > SAME {
            return Err(PostError::OtherAngles {
                pass: pass.name.clone(),
                found: [*begins, *ends].map(crate::math::units::deg_from_rad),
                expected: [from_rad, to_rad].map(crate::math::units::deg_from_rad),
            });
        }
        let pieces = motion.pieces().into_iter();
        let judged: Result<Vec<_>, _> =
            pieces.map(|piece| motion.judge(&chain, piece, posted_pass.tolerance_mm)).collect();
        compared.add(index, run, &judged?, posted_pass.tolerance_mm, posted_pass.time_s);
    }
    check_rapids(request, moves)?;
    Ok(compared)
}

/// Rapids of C and Z must be clear of the bar.
fn check_rapids(request: &InsertPostRequest<'_>, moves: &[ProgramRun]) -> Result<(), PostError> {
    let clear_mm = request.clear_mm + request.x_shift_mm;
    for pair in moves.windows(2) {
        let [from, to] = pair else { continue };
        if to.time_s.is_some() {
            continue;
        }
        let moves_by = |axis: NcAxis| (to.pose[axis.index()] - from.pose[axis.index()]).abs();
        let x = NcAxis::X.index();
        let at_mm = from.pose[x].min(to.pose[x]);
        // An axis without a position yet is not compared.
        let is_clear = !from.pose[x].is_finite() || at_mm > clear_mm - SAME;
        if (moves_by(NcAxis::C) > SAME || moves_by(NcAxis::Z) > SAME) && !is_clear {
            return Err(PostError::RapidNotClear { feature: request.name.clone(), at_mm, clear_mm });
        }
    }
    Ok(())
}
