// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! NC programs of turned parts: C, X and Z along the spiral of a round insert, in inverse time.
//!
//! Nothing of a spiral repeats from turn to turn, so every pass is one run of blocks in the main program, between two rapids with the insert
//! clear of the bar. C counts on from pass to pass. Every block moves all three axes in proportion; the time of a block is that of the plan's
//! law of C.

mod blocks;
mod compare;
mod spiral;

pub use compare::compare_insert;

use super::error::{bad_unless, check_control, positive};
use super::{NcControl, PostError, ROUNDED_OFF};
use crate::gcode::archimedean::{ChainDeviation, Knots};
use crate::gcode::{Block, Dialect, Direction, NcAxis, Program, Step, Target, Tool, raised_feeds};
use crate::math::units::{TURN_RAD, um_from_mm};
use crate::toolpath::insert_path::{InsertPath, SpindleLaw};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use blocks::SpiralBlocks;

/// Maximum number of passes of a program.
const MAX_PASSES: usize = 1000;

/// A pass of the insert.
#[derive(Debug, Clone)]
pub struct InsertPassRequest<'a> {
    pub name: String,
    /// Path of the insert's centre.
    pub path: &'a InsertPath,
    /// Motion of C along the path.
    pub spindle: &'a SpindleLaw,
    /// Share of the speed of that motion at which C turns, above 0 and up to 1.
    pub speed_share: f64,
    /// Maximum deviation of the program from the path along an axis (mm).
    pub tolerance_mm: f64,
    /// Largest tolerance for controls that read blocks too slowly (mm).
    pub widest_tolerance_mm: f64,
    /// Permitted positions of the knots. Where Z has its own law, too, they lie on the curve.
    pub knots: Knots,
}

/// Input of the program of a turned part.
#[derive(Debug, Clone)]
pub struct InsertPostRequest<'a> {
    pub name: String,
    /// Number of the program.
    pub number: u32,
    /// Header comments.
    pub header: Vec<String>,
    pub tool: Tool,
    /// Direction and speed of the insert's spindle, if the program sets them.
    pub spindle: Option<(Direction, u32)>,
    /// True if the coolant is on.
    pub coolant: bool,
    pub control: NcControl,
    /// Programmed X less X of the insert's centre (mm): −R for a program of the edge.
    pub x_shift_mm: f64,
    /// X of the insert's centre clear of the bar (mm).
    pub clear_mm: f64,
    /// The passes, in their order.
    pub passes: Vec<InsertPassRequest<'a>>,
}

/// One pass as it is programmed.
#[derive(Debug, Clone, PartialEq)]
pub struct PostedInsertPass {
    /// The tolerance that was used (mm).
    pub tolerance_mm: f64,
    /// Deviation of the programmed blocks from the path, and the steps of their slopes: axis 0 is X, axis 1 is Z.
    pub deviation: ChainDeviation,
    /// Theoretical number of blocks.
    pub theoretical_blocks: f64,
    pub blocks: usize,
    /// Turns of C.
    pub turns: f64,
    /// Blocks that take longer than the plan, because the control has no shorter ones.
    pub lengthened: usize,
    /// Most blocks in a second, over ten of them.
    pub blocks_s: f64,
    /// Largest step of the velocity of an axis from a block to the next (mm/s).
    pub velocity_step_mm_s: f64,
    /// Time of its feeds (s).
    pub time_s: f64,
    /// Angle of C by which the pass is shifted: whole turns before it (rad).
    pub c_shift_rad: f64,
    /// Knots as they are programmed: turned angle of the path (rad), X and Z of the insert's centre (mm).
    pub knots: Vec<(f64, [f64; 2])>,
}

/// The program of a turned part and its properties.
#[derive(Debug, Clone, PartialEq)]
pub struct PostedInsertProgram {
    pub program: Program,
    pub passes: Vec<PostedInsertPass>,
    /// Time of its feeds (s).
    pub feed_time_s: f64,
}

/// Makes the program of a turned part.
///
/// # Errors
/// Blocks that the control cannot run, or a path without a program, with the value and the limit.
pub fn post_insert(request: &InsertPostRequest<'_>) -> Result<PostedInsertProgram, PostError> {
    check(request)?;
    let mut posted = PostedInsertProgram { program: empty(request), passes: Vec::new(), feed_time_s: 0.0 };
    let mut c_now = 0;
    for pass in &request.passes {
        c_now = posted.add_pass(request, pass, c_now).map_err(|error| match error {
            PostError::Of { .. } | PostError::TooManyBlocks { .. } => error,
            other => other.within(&request.name, &pass.name),
        })?;
    }
    posted.finish(request)?;
    let raised = if request.control.dialect == Dialect::LinuxCnc { raised_feeds(&posted.program) } else { Vec::new() };
    raised.into_iter().next().map_or(Ok(posted), |raised| Err(PostError::RaisedFeed(raised)))
}

/// Refuses numbers that make no program.
fn check(request: &InsertPostRequest<'_>) -> Result<(), PostError> {
    check_control(&request.control)?;
    for (what, value) in [("the clear position in mm", request.clear_mm), ("the shift of X in mm", request.x_shift_mm)]
    {
        bad_unless(value.is_finite(), what, value, "it must be a number of mm")?;
    }
    if request.passes.is_empty() {
        return Err(PostError::Nothing { what: "no pass".into() });
    }
    let count = request.passes.len();
    bad_unless(count <= MAX_PASSES, "the number of passes", count as f64, "at most 1000 are allowed")?;
    for pass in &request.passes {
        let (tolerance_mm, widest_mm) = (pass.tolerance_mm, pass.widest_tolerance_mm);
        let share = pass.speed_share;
        let is_share = share > 0.0 && share <= 1.0;
        let is_wide = widest_mm.is_finite() && widest_mm >= tolerance_mm;
        positive("the tolerance in mm", tolerance_mm)
            .and_then(|()| bad_unless(is_share, "the share of the speed", share, "it must be above 0 and up to 1"))
            .and_then(|()| bad_unless(is_wide, "the widest tolerance in mm", widest_mm, "at least the tolerance"))
            .map_err(|error| error.within(&request.name, &pass.name))?;
    }
    Ok(())
}

/// The program before its first pass: the insert rotates.
fn empty(request: &InsertPostRequest<'_>) -> Program {
    let control = &request.control;
    let mut main = alloc::vec![Step::Block(Block::ToolChange(request.tool.number))];
    if let Some((direction, rpm)) = request.spindle {
        main.push(Step::Block(Block::SpindleOn { direction, rpm }));
    }
    Program {
        name: request.name.clone(),
        number: request.number,
        header: request.header.clone(),
        format: control.format,
        tools: alloc::vec![request.tool.clone()],
        main,
        subprograms: Vec::new(),
    }
}

impl InsertPostRequest<'_> {
    /// Target of the clear position of X.
    fn clear(&self) -> Result<Target, PostError> {
        Ok(Target::default().with(NcAxis::X, self.control.format.count(NcAxis::X, self.clear_mm + self.x_shift_mm)?))
    }
}

impl PostedInsertProgram {
    fn push(&mut self, block: Block) {
        self.program.main.push(Step::Block(block));
    }

    /// Adds a pass; `c_now` is the turned angle of C before it (increments). Returns the angle behind it.
    fn add_pass(
        &mut self,
        request: &InsertPostRequest<'_>,
        pass: &InsertPassRequest<'_>,
        c_now: i64,
    ) -> Result<i64, PostError> {
        let format = request.control.format;
        let blocks = SpiralBlocks::fitting(request, pass)?;
        let (Some(first), Some(last)) = (blocks.knots().first().copied(), blocks.knots().last().copied()) else {
            return Ok(c_now);
        };
        let shift = c_shift(request, (first.c, last.c), c_now)?;
        let clear = Block::Rapid(request.clear()?);
        self.push(Block::Comment(format!("{}: {}", pass.name, blocks.title())));
        self.push(clear.clone());
        if request.coolant && self.passes.is_empty() {
            self.push(Block::Coolant(true));
        }
        let tolerance_mm = request.control.path_tolerance_mm.unwrap_or(ROUNDED_OFF * blocks.tolerance_mm());
        let increments = format.count(NcAxis::Z, tolerance_mm)?.max(1);
        self.push(Block::PathTolerance(increments));
        let sense = i64::from(request.control.rotation_sense);
        let c_at = |c: i64| sense * (c + shift);
        self.push(Block::Rapid(Target::default().with(NcAxis::Z, first.z).with(NcAxis::C, c_at(first.c))));
        self.push(Block::Rapid(Target::default().with(NcAxis::X, first.x)));
        for (pair, time_s) in blocks.knots().windows(2).zip(blocks.times_s()) {
            let (from, to) = (pair[0], pair[1]);
            let mut target = Target::default().with(NcAxis::C, c_at(to.c));
            if to.x != from.x {
                target = target.with(NcAxis::X, to.x);
            }
            if to.z != from.z {
                target = target.with(NcAxis::Z, to.z);
            }
            self.push(Block::Feed { target, time_s: *time_s });
        }
        self.push(clear);
        let posted = blocks.into_posted(request, format.value(NcAxis::C, shift));
        self.feed_time_s += posted.time_s;
        self.passes.push(posted);
        Ok(last.c + shift)
    }

    /// Ends the program after the last pass: everything off, Z and C back where they began.
    fn finish(&mut self, request: &InsertPostRequest<'_>) -> Result<(), PostError> {
        if request.coolant {
            self.push(Block::Coolant(false));
        }
        if request.spindle.is_some() {
            self.push(Block::SpindleOff);
        }
        let format = request.control.format;
        let mut back = Target::default().with(NcAxis::C, format.count(NcAxis::C, 0.0)?);
        if let Some(pass) = request.passes.first() {
            back = back.with(NcAxis::Z, format.count(NcAxis::Z, pass.path.z_at(pass.path.x().start()).value)?);
        }
        self.push(Block::Rapid(back));
        Ok(())
    }
}

/// Whole turns (increments) by which a pass is shifted, so that C counts on. C winds back, with the insert clear of the bar, if the control
/// has no digits for more turns.
fn c_shift(request: &InsertPostRequest<'_>, (first, last): (i64, i64), c_now: i64) -> Result<i64, PostError> {
    let control = &request.control;
    let whole_turn = control.format.count(NcAxis::C, TURN_RAD)?;
    let max = control.dialect.max_c_increments(control.format);
    let on = (c_now - first).div_euclid(whole_turn) * whole_turn;
    let on = if on + first < c_now { on + whole_turn } else { on };
    if on + last <= max {
        return Ok(on);
    }
    if last <= max {
        return Ok(0);
    }
    let turns = |count: i64| count as f64 / whole_turn as f64;
    Err(PostError::TooManyTurns { turns: turns(last), max: turns(max), decimals: control.format.decimals(NcAxis::C) })
}

impl SpiralBlocks {
    /// Summary for the operator.
    fn title(&self) -> String {
        let turns = self.turns();
        let (error_um, tolerance_um) = (um_from_mm(self.deviation().error_mm), um_from_mm(self.tolerance_mm()));
        format!(
            "{turns:.1} turns, {} blocks, largest error {error_um:.4} um, tolerance {tolerance_um:.4} um",
            self.times_s().len()
        )
    }
}
