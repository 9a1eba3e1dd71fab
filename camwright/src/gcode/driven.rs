// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Motion of the machine, block by block, computed from the typed program and not from its text.

use super::{Block, Call, NcAxis, Program, Step, Target};
use alloc::vec::Vec;

/// A motion of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenMove {
    /// The subprogram it stands in, by its place in the list; `None` in the main program.
    pub subprogram: Option<usize>,
    /// The call it is driven by: how many came before.
    pub call: Option<usize>,
    /// Its block in the main program or the subprogram, from 0.
    pub block: usize,
    /// Position of the axes at the end, shifts included, in increments; `None` for axes that no block has named yet.
    pub pose: [Option<i64>; 4],
    /// Duration (s); `None` for a rapid.
    pub time_s: Option<f64>,
}

/// All motions of a program in the order in which they are driven. What [`super::Dialect::write`] refuses is omitted.
#[must_use]
pub fn driven(program: &Program) -> Vec<DrivenMove> {
    let mut moves = Vec::new();
    let mut pose = [None; 4];
    let mut calls = 0;
    for (block, step) in program.main.iter().enumerate() {
        match step {
            Step::Block(step) => {
                moves.extend(motion(step, &Target::default(), &mut pose).map(|time_s| DrivenMove {
                    subprogram: None,
                    call: None,
                    block,
                    pose,
                    time_s,
                }));
            }
            Step::Call(call) => {
                let Some(sub) = program.subprograms.get(call.subprogram) else { continue };
                let shift = shift_of(program, call);
                for (block, step) in sub.blocks.iter().enumerate() {
                    let (subprogram, number) = (Some(call.subprogram), Some(calls));
                    moves.extend(motion(step, &shift, &mut pose).map(|time_s| DrivenMove {
                        subprogram,
                        call: number,
                        block,
                        pose,
                        time_s,
                    }));
                }
                calls += 1;
            }
        }
    }
    moves
}

/// Shift of each axis by a call.
pub(super) fn shift_of(program: &Program, call: &Call) -> Target {
    let shift = Target::default().with(NcAxis::C, call.phase);
    match program.subprograms.get(call.subprogram).and_then(|sub| sub.offset_axis) {
        Some(axis) => shift.with(axis.into(), call.offset),
        None => shift,
    }
}

/// Time of a block if it is a motion, after which the axes are at `pose`.
fn motion(block: &Block, shift: &Target, pose: &mut [Option<i64>; 4]) -> Option<Option<f64>> {
    let (target, time_s) = match block {
        Block::Rapid(target) => (target, None),
        Block::Feed { target, time_s } => (target, Some(*time_s)),
        _ => return None,
    };
    for (axis, count) in target.named() {
        pose[axis.index()] = Some(count.saturating_add(shift.value(axis).unwrap_or(0)));
    }
    Some(time_s)
}
