// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Summary of a program, for the operator and for scripts.

use super::request::ToPost;
use camwright::gcode::ProgramFile;
use camwright::gcode::post::{PostedProgram, PostedTurn, ProgramComparison};
use camwright::math::units::{deg_from_rad, um_from_mm};
use serde::Serialize;

/// A shortest block that is as good as none (s).
const LIKE_NONE_S: f64 = 1e-4;

/// A program, as `summary.json` has it.
#[derive(Debug, Clone, Serialize)]
pub struct ProgramSummary {
    /// Name of the job.
    pub job: String,
    /// Its hash, 64 hexadecimal digits.
    pub job_hash: String,
    /// Files of the program.
    pub files: Vec<String>,
    /// Blocks of all files.
    pub lines: usize,
    /// Turns with a subprogram.
    pub turns: Vec<TurnSummary>,
    pub calls: usize,
    /// Time of all feeds (s).
    pub feed_time_s: f64,
    /// Result of reading the files back.
    pub read_back: ReadBackSummary,
    /// Notes, one sentence each.
    pub notes: Vec<String>,
}

/// A turn of a pass.
#[derive(Debug, Clone, Serialize)]
pub struct TurnSummary {
    pub feature: String,
    pub pass: String,
    pub calls: usize,
    /// Blocks of a call.
    pub blocks: usize,
    /// Archimedean segments of a turn at full depth.
    pub segments: usize,
    /// Theoretical number of segments.
    pub theoretical_segments: f64,
    /// Tolerance that was used (µm).
    pub tolerance_um: f64,
    /// Largest distance along an axis from the path (µm).
    pub error_um: f64,
    pub error_axis: String,
    /// Angle of C in the part's frame there (deg).
    pub error_at_deg: f64,
    /// Largest step of the slope from a segment to the next (mm/deg).
    pub slope_step_mm_deg: f64,
    pub slope_axis: String,
    /// Angle of C in the part's frame there (deg).
    pub slope_at_deg: f64,
    /// Largest step of the velocity of an axis (mm/s): what the control has to round off, and the waviness of the surface.
    pub velocity_step_mm_s: f64,
    /// Most blocks in a second, over ten of them.
    pub blocks_s: f64,
    /// Time of a call (s).
    pub time_s: f64,
}

/// The files, read again and compared with the paths they were made for.
#[derive(Debug, Clone, Serialize)]
pub struct ReadBackSummary {
    pub moves: usize,
    /// Largest distance along an axis from the path (µm).
    pub error_um: f64,
    /// Largest share of its tolerance that a call is off.
    pub share_of_tolerance: f64,
    /// Largest difference of a call's time from what was meant (s).
    pub time_error_s: f64,
}

pub(super) fn summary(
    to_post: &ToPost<'_>,
    posted: &PostedProgram,
    compared: &ProgramComparison,
    files: &[ProgramFile],
) -> ProgramSummary {
    let mut notes = to_post.notes.clone();
    for turn in &posted.turns {
        let of = &to_post.request.features[turn.feature];
        let pass = &of.passes[turn.pass];
        if turn.tolerance_mm > pass.tolerance_mm {
            let control = &to_post.request.control;
            let shortest_s = control.dialect.shortest_block_s();
            // Only some have a format that knows no short ones.
            let none_shorter =
                if shortest_s > LIKE_NONE_S { format!(", none shorter than {shortest_s:.4} s") } else { String::new() };
            notes.push(format!(
                "{}, pass {}: a tolerance of {:.3} um instead of {:.3}, so that the control reads no more than {:.0} blocks a \
                 second{none_shorter}",
                of.name,
                pass.name,
                um_from_mm(turn.tolerance_mm),
                um_from_mm(pass.tolerance_mm),
                control.max_blocks_s,
            ));
        }
    }
    for turn in posted.turns.iter().filter(|turn| turn.lengthened > 0) {
        let of = &to_post.request.features[turn.feature];
        notes.push(format!(
            "{}, pass {}: {} of {} blocks take {:.4} s, the least that the control reads as F, and C is slower in them",
            of.name,
            of.passes[turn.pass].name,
            turn.lengthened,
            turn.blocks,
            to_post.request.control.dialect.shortest_block_s()
        ));
    }
    let turn = |(index, turn): (usize, &PostedTurn)| {
        let of = &to_post.request.features[turn.feature];
        let letter = |axis: usize| turn.axes.get(axis).map_or_else(String::new, |axis| axis.letter().to_string());
        let deviation = &turn.deviation;
        TurnSummary {
            feature: of.name.clone(),
            pass: of.passes[turn.pass].name.clone(),
            calls: posted.calls.iter().filter(|call| call.0 == index).count(),
            blocks: turn.blocks,
            segments: turn.pieces_of_turn,
            theoretical_segments: turn.theoretical_pieces,
            tolerance_um: um_from_mm(turn.tolerance_mm),
            error_um: um_from_mm(deviation.error_mm),
            error_axis: letter(deviation.error_axis),
            error_at_deg: deg_from_rad(deviation.error_at_rad),
            // A slope per radian is smaller per degree.
            slope_step_mm_deg: deviation.slope_jump_mm_rad / deg_from_rad(1.0),
            slope_axis: letter(deviation.slope_axis),
            slope_at_deg: deg_from_rad(deviation.slope_at_rad),
            velocity_step_mm_s: turn.velocity_step_mm_s,
            blocks_s: turn.blocks_s,
            time_s: turn.time_s,
        }
    };
    ProgramSummary {
        job: to_post.job.to_owned(),
        job_hash: to_post.job_hash.to_owned(),
        files: files.iter().map(|file| file.name.clone()).collect(),
        lines: files.iter().map(|file| file.text.lines().count()).sum(),
        turns: posted.turns.iter().enumerate().map(turn).collect(),
        calls: posted.calls.len(),
        feed_time_s: posted.feed_time_s,
        read_back: ReadBackSummary {
            moves: compared.moves,
            error_um: compared.error_um(),
            share_of_tolerance: compared.share_of_tolerance,
            time_error_s: compared.time_error_s,
        },
        notes,
    }
}
