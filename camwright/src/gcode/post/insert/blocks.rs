// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Blocks of a pass in whole increments: cut, rounded, timed, and judged as they will be driven.

use super::spiral::InsertMotion;
use super::{InsertPassRequest, InsertPostRequest, PostedInsertPass};
use crate::gcode::NcAxis;
use crate::gcode::archimedean::{Chain, ChainDeviation, ChainRequest, Travelling, theoretical_pieces};
use crate::gcode::post::PostError;
use crate::gcode::post::pieces::{ROUNDED_DOWN, WIDER, blocks_per_second};
use crate::math::units::{TURN_RAD, deg_from_rad, rpm_from_rad_s, um_from_mm};
use alloc::vec::Vec;

/// Maximum number of blocks of a pass: controls hold programs of some megabytes.
const MAX_BLOCKS: usize = 1_000_000;

/// Share of the tolerance that the block rate asks for: the next attempt begins a little below it.
const NEXT: f64 = 0.95;

/// A knot in increments; `c` is the turned angle of the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SpiralKnot {
    pub(super) c: i64,
    pub(super) x: i64,
    pub(super) z: i64,
}

/// The blocks of a pass.
pub(super) struct SpiralBlocks {
    knots: Vec<SpiralKnot>,
    /// Last knot of every piece of the path.
    ends: Vec<usize>,
    times_s: Vec<f64>,
    tolerance_mm: f64,
    deviation: ChainDeviation,
    theoretical: f64,
    turns: f64,
    lengthened: usize,
    blocks_s: f64,
    velocity_step_mm_s: f64,
}

impl SpiralBlocks {
    /// The fewest blocks within the tolerance, or within a wider one where the control would not read them in time.
    pub(super) fn fitting(request: &InsertPostRequest<'_>, pass: &InsertPassRequest<'_>) -> Result<Self, PostError> {
        let motion = InsertMotion::new(pass);
        let min_s = request.control.dialect.shortest_block_s();
        let max_s = request.control.max_blocks_s.min(1.0 / min_s);
        let mut tolerance_mm = pass.tolerance_mm;
        loop {
            let mut blocks = Self::new(request, pass, &motion, tolerance_mm)?;
            let is_last = tolerance_mm >= pass.widest_tolerance_mm;
            let excess = blocks.blocks_s / max_s;
            if excess <= 1.0 {
                blocks.lengthen(min_s);
                return Ok(blocks);
            }
            if is_last {
                return Err(PostError::TooManyBlocks {
                    feature: request.name.clone(),
                    pass: pass.name.clone(),
                    blocks_s: blocks.blocks_s,
                    max_s,
                    tolerance_um: um_from_mm(tolerance_mm),
                    fits_rpm: rpm_from_rad_s(ROUNDED_DOWN / excess * motion.fastest_rad_s()),
                });
            }
            // The number of blocks falls with the root of the tolerance.
            let wider = WIDER.max(NEXT * excess * excess);
            tolerance_mm = (tolerance_mm * wider).min(pass.widest_tolerance_mm);
        }
    }

    fn new(
        request: &InsertPostRequest<'_>,
        pass: &InsertPassRequest<'_>,
        motion: &InsertMotion<'_>,
        tolerance_mm: f64,
    ) -> Result<Self, PostError> {
        let (from_rad, to_rad) = motion.range();
        let mut blocks = Self {
            knots: Vec::new(),
            ends: Vec::new(),
            times_s: Vec::new(),
            tolerance_mm,
            deviation: ChainDeviation::default(),
            theoretical: 0.0,
            turns: (to_rad - from_rad) / TURN_RAD,
            lengthened: 0,
            blocks_s: 0.0,
            velocity_step_mm_s: 0.0,
        };
        let rounding_mm = motion.rounding_mm(request.control.format);
        let (x, z) = (|turned_rad: f64| motion.x_at(turned_rad), |turned_rad: f64| motion.z_at(turned_rad));
        let both: [Travelling<'_>; 2] = [&x, &z];
        // Z in proportion to C is straight in every block.
        let travels = if motion.z_travels() { &both[..] } else { &both[..1] };
        for (from_rad, to_rad) in motion.pieces() {
            let knots = pass.knots;
            let piece = ChainRequest { travels, from_rad, to_rad, tolerance_mm, rounding_mm, knots };
            blocks.add(request, motion, &Chain::evenly(&piece)?)?;
            blocks.theoretical += theoretical_pieces(&piece)?;
        }
        let times: Vec<f64> =
            blocks.knots.iter().map(|knot| motion.time_at(request.control.format.value(NcAxis::C, knot.c))).collect();
        blocks.times_s = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        blocks.blocks_s = blocks_per_second(&blocks.times_s);
        blocks.judge(request, motion)?;
        Ok(blocks)
    }

    /// Knots of a piece in increments, after those that are there; ends meet.
    fn add(
        &mut self,
        request: &InsertPostRequest<'_>,
        motion: &InsertMotion<'_>,
        chain: &Chain,
    ) -> Result<(), PostError> {
        let format = request.control.format;
        for (knot, turned_rad) in chain.angles_rad.iter().enumerate() {
            let c = format.count(NcAxis::C, *turned_rad)?;
            let z_mm = match chain.positions_mm.get(1) {
                Some(positions) => positions[knot],
                None => motion.z_at(*turned_rad).value,
            };
            let x = request.x_count(chain.positions_mm[0][knot])?;
            let next = SpiralKnot { c, x, z: format.count(NcAxis::Z, z_mm)? };
            // Two knots that C cannot resolve are one; the first knot and that where pieces meet lie on the path.
            match self.knots.last_mut() {
                Some(last) if last.c == c => *last = next,
                _ => self.knots.push(next),
            }
        }
        if self.knots.len() > MAX_BLOCKS {
            let (blocks, allowed) = (self.knots.len() as u64, MAX_BLOCKS as u64);
            return Err(PostError::TooLongPass { blocks, allowed });
        }
        self.ends.push(self.knots.len() - 1);
        Ok(())
    }

    /// Blocks that the control's format has no time for take as long as it has.
    fn lengthen(&mut self, min_s: f64) {
        for time_s in &mut self.times_s {
            if *time_s < min_s {
                *time_s = min_s;
                self.lengthened += 1;
            }
        }
        self.blocks_s = blocks_per_second(&self.times_s);
    }

    /// Judges the blocks, in increments, against the path.
    fn judge(&mut self, request: &InsertPostRequest<'_>, motion: &InsertMotion<'_>) -> Result<(), PostError> {
        let format = request.control.format;
        let angle = |knot: &SpiralKnot| format.value(NcAxis::C, knot.c);
        let mut begin = 0;
        for end in &self.ends {
            let knots = &self.knots[begin..=*end];
            begin = *end;
            let (Some(first), Some(last)) = (knots.first(), knots.last()) else { continue };
            if first.c >= last.c {
                continue;
            }
            let chain = Chain {
                angles_rad: knots.iter().map(angle).collect(),
                positions_mm: alloc::vec![
                    knots.iter().map(|knot| request.x_value(knot.x)).collect(),
                    knots.iter().map(|knot| format.value(NcAxis::Z, knot.z)).collect(),
                ],
            };
            let found = motion.judge(&chain, (angle(first), angle(last)), self.tolerance_mm)?;
            let worst = &mut self.deviation;
            if found.error_mm > worst.error_mm || found.error_mm.is_nan() {
                (worst.error_mm, worst.error_axis) = (found.error_mm, found.error_axis);
                worst.error_at_rad = found.error_at_rad;
            }
        }
        self.find_steepest_step(request);
        self.velocity_step_mm_s = self.deviation.slope_jump_mm_rad * motion.fastest_rad_s();
        let error_mm = self.deviation.error_mm;
        if error_mm > self.tolerance_mm || error_mm.is_nan() {
            return Err(PostError::OffThePath {
                error_um: um_from_mm(error_mm),
                allowed_um: um_from_mm(self.tolerance_mm),
                at_deg: deg_from_rad(self.deviation.error_at_rad),
            });
        }
        Ok(())
    }

    /// Largest step of a slope from a block to the next.
    fn find_steepest_step(&mut self, request: &InsertPostRequest<'_>) {
        let format = request.control.format;
        let place = |knot: &SpiralKnot| [request.x_value(knot.x), format.value(NcAxis::Z, knot.z)];
        let slopes = |pair: &[SpiralKnot]| {
            let (from, to) = (place(&pair[0]), place(&pair[1]));
            let turned = format.value(NcAxis::C, pair[1].c - pair[0].c);
            [(to[0] - from[0]) / turned, (to[1] - from[1]) / turned]
        };
        for knots in self.knots.windows(3) {
            let (before, after) = (slopes(&knots[..2]), slopes(&knots[1..]));
            for axis in 0..2 {
                let jump = (after[axis] - before[axis]).abs();
                if jump > self.deviation.slope_jump_mm_rad {
                    (self.deviation.slope_jump_mm_rad, self.deviation.slope_axis) = (jump, axis);
                    self.deviation.slope_at_rad = format.value(NcAxis::C, knots[1].c);
                }
            }
        }
    }

    pub(super) fn knots(&self) -> &[SpiralKnot] {
        &self.knots
    }

    pub(super) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    pub(super) fn tolerance_mm(&self) -> f64 {
        self.tolerance_mm
    }

    pub(super) fn deviation(&self) -> &ChainDeviation {
        &self.deviation
    }

    pub(super) fn turns(&self) -> f64 {
        self.turns
    }

    /// Result for the report.
    pub(super) fn into_posted(self, request: &InsertPostRequest<'_>, c_shift_rad: f64) -> PostedInsertPass {
        let format = request.control.format;
        let value = |knot: &SpiralKnot| {
            (format.value(NcAxis::C, knot.c), [request.x_value(knot.x), format.value(NcAxis::Z, knot.z)])
        };
        PostedInsertPass {
            tolerance_mm: self.tolerance_mm,
            deviation: self.deviation,
            theoretical_blocks: self.theoretical,
            blocks: self.times_s.len(),
            turns: self.turns,
            lengthened: self.lengthened,
            blocks_s: self.blocks_s,
            velocity_step_mm_s: self.velocity_step_mm_s,
            time_s: self.times_s.iter().sum(),
            c_shift_rad,
            knots: self.knots.iter().map(value).collect(),
        }
    }
}
