// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! NC programs of cutter paths: a subprogram for every turn of a cutter around a cam or along a groove, called with its phase and with
//! what is left of the depth, and a main program that calls them.
//!
//! A subprogram comes in over an angle before the turn, turns, and leaves over as much behind it, so that no place on the part sees the cutter
//! arrive or stand. Along a groove of several turns it makes all of them; into an open groove it comes beyond the part. It is in the part's
//! own angle, u = σ·(θ − α), read forwards while C turns forwards; its call shifts C by the phase and the infeed axis by what is left. Every
//! block is one piece of a chain of Archimedean segments in whole increments of the control, with the time that C takes for it.

mod compare;
mod error;
mod insert;
mod pieces;
mod turn;

pub use compare::{ProgramComparison, ProgramRun, compare};
pub use error::PostError;
pub use insert::{
    InsertPassRequest, InsertPostRequest, PostedInsertPass, PostedInsertProgram, compare_insert, post_insert,
};

use crate::gcode::archimedean::{ChainDeviation, Knots};
use crate::gcode::{
    Block, Call, Dialect, Direction, NcAxis, NumberFormat, Program, Step, Subprogram, Target, Tool, raised_feeds,
};
use crate::math::units::TURN_RAD;
use crate::toolpath::cutter_path::{CarriageAxis, CutterPath};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use pieces::Pieces;
use turn::SubprogramMotion;

/// C is programmed with fewer increments: eight digits, which all controls read.
const C_INCREMENTS: i64 = 100_000_000;

/// Rounding that a control may apply, in tolerances of the pass.
const ROUNDED_OFF: f64 = 4.0;

/// Longest name of a subprogram (characters): SINUMERIK has 24, of which three may be a beginning that makes it a name.
const MAX_NAME: usize = 20;

/// The control that runs a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NcControl {
    pub dialect: Dialect,
    pub format: NumberFormat,
    /// Blocks that it reads in a second for as long as it takes.
    pub max_blocks_s: f64,
    /// Path tolerance between two blocks (mm); `None`: four times the tolerance of each pass.
    pub path_tolerance_mm: Option<f64>,
    /// σ: +1 if a positive C turns the part clockwise seen from +Z, −1 if against it.
    pub rotation_sense: i8,
}

/// Speed of C.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "a law is a function")]
pub enum ProgramTurnSpeed<'a> {
    /// At one speed (rad/s).
    WorkSpeed(f64),
    /// The cutter's centre runs along its path at one speed.
    AlongPath {
        /// Feed (mm/s).
        feed_mm_s: f64,
        /// Largest speed of C (rad/s).
        max_rad_s: f64,
    },
    /// Speed of C (rad/s) over the part's angle u (rad), the same in every turn.
    Law(&'a dyn Fn(f64) -> f64),
}

/// A pass: the cutter at what is left of the depth.
#[derive(Clone)]
#[allow(missing_debug_implementations, reason = "a speed may be a function")]
pub struct PassRequest<'a> {
    pub name: String,
    /// Stock left to the full depth in each call, along the infeed axis (mm), in the order of the calls.
    pub leaves_mm: Vec<f64>,
    /// Most that the program may be off the path along an axis (mm).
    pub tolerance_mm: f64,
    /// Largest tolerance for controls that read blocks too slowly (mm).
    pub widest_tolerance_mm: f64,
    /// Permitted positions of the knots.
    pub knots: Knots,
    /// Speed of C.
    pub speed: ProgramTurnSpeed<'a>,
    /// Turns at full depth in every call.
    pub turns: u32,
}

/// Lead-in and lead-out of the cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lead {
    /// Distance from the depth at the start, along the infeed axis (mm).
    pub height_mm: f64,
    /// Angle of C over which it comes (rad).
    pub angle_rad: f64,
    /// It leaves the same way; else it is drawn out where it stands.
    pub leaves_turning: bool,
}

/// Feature made by a cutter: a cam, or a wall of a groove.
#[derive(Clone)]
#[allow(missing_debug_implementations, reason = "a speed may be a function")]
pub struct FeatureRequest<'a> {
    pub name: String,
    /// α, from the part's zero to angle 0 of the path (rad).
    pub phase_rad: f64,
    /// The path at full depth.
    pub path: &'a CutterPath,
    /// Position of axes that do not travel, the infeed axis included (mm).
    pub stands_mm: Vec<(CarriageAxis, f64)>,
    /// Place of the infeed axis at which the cutter is clear of the part all round (mm).
    pub clear_mm: f64,
    /// Lead-in and lead-out.
    pub lead: Lead,
    /// The passes, in their order.
    pub passes: Vec<PassRequest<'a>>,
}

/// Input of a program.
#[derive(Clone)]
#[allow(missing_debug_implementations, reason = "a speed may be a function")]
pub struct PostRequest<'a> {
    pub name: String,
    /// Its number; subprograms have those that follow.
    pub number: u32,
    /// Lines for people at its head.
    pub header: Vec<String>,
    pub tool: Tool,
    /// Direction and speed of the cutter's spindle, if the program sets them.
    pub spindle: Option<(Direction, u32)>,
    /// True if the coolant is on.
    pub coolant: bool,
    pub control: NcControl,
    /// Features in machining order.
    pub features: Vec<FeatureRequest<'a>>,
}

/// One turn as it is programmed.
#[derive(Debug, Clone, PartialEq)]
pub struct PostedTurn {
    /// Its feature, by its place in the request.
    pub feature: usize,
    /// Its pass in the feature.
    pub pass: usize,
    /// Its subprogram in the program.
    pub subprogram: usize,
    /// The tolerance that was used (mm).
    pub tolerance_mm: f64,
    /// Deviation of the programmed pieces from the path, with leads, and the steps of their slopes.
    pub deviation: ChainDeviation,
    /// Pieces of a turn at full depth, without leads.
    pub pieces_of_turn: usize,
    /// Theoretical number of pieces.
    pub theoretical_pieces: f64,
    pub blocks: usize,
    /// Blocks that take longer than the speed of C asks for, because the control has no shorter ones.
    pub lengthened: usize,
    /// Most blocks in a second, over ten of them.
    pub blocks_s: f64,
    /// Largest step of the velocity of an axis from a piece to the next (mm/s).
    pub velocity_step_mm_s: f64,
    /// Time of a call, without rapids (s).
    pub time_s: f64,
    /// Knots as they are programmed: angle u (rad) and the axes that move (mm).
    pub knots: Vec<(f64, Vec<f64>)>,
    /// The axes that move in it.
    pub axes: Vec<CarriageAxis>,
}

/// A program and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PostedProgram {
    pub program: Program,
    /// Every turn that it has a subprogram for.
    pub turns: Vec<PostedTurn>,
    /// Its calls: the turn, the shift of C (rad), and what is left along the infeed axis (mm).
    pub calls: Vec<(usize, f64, f64)>,
    /// Time of its feeds (s).
    pub feed_time_s: f64,
}

/// Makes the program of a request.
///
/// # Errors
/// What the control cannot run or the path does not give, with how much of it is allowed.
pub fn post(request: &PostRequest<'_>) -> Result<PostedProgram, PostError> {
    error::check(request)?;
    let mut posted = PostedProgram { program: empty(request), turns: Vec::new(), calls: Vec::new(), feed_time_s: 0.0 };
    let mut c_end = 0_i64;
    for (feature, of) in request.features.iter().enumerate() {
        posted.rise_clear(request, of)?;
        for (pass, of_pass) in of.passes.iter().enumerate() {
            let turn = posted.add_turn(request, (feature, pass))?;
            posted.round_off(request, turn)?;
            for leaves_mm in &of_pass.leaves_mm {
                c_end = posted.call(request, of, turn, *leaves_mm, c_end)?;
            }
        }
    }
    posted.finish(request)?;
    let raised = if request.control.dialect == Dialect::LinuxCnc { raised_feeds(&posted.program) } else { Vec::new() };
    raised.into_iter().next().map_or(Ok(posted), |raised| Err(PostError::RaisedFeed(raised)))
}

/// The program before its first cam: the cutter changed, turning, coolant on.
fn empty(request: &PostRequest<'_>) -> Program {
    let control = &request.control;
    let mut main = alloc::vec![Step::Block(Block::ToolChange(request.tool.number))];
    if let Some((direction, rpm)) = request.spindle {
        main.push(Step::Block(Block::SpindleOn { direction, rpm }));
    }
    if let Some(Ok(increments)) = control.path_tolerance_mm.map(|mm| control.format.count(NcAxis::Z, mm)) {
        main.push(Step::Block(Block::PathTolerance(increments.max(1))));
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

impl PostedProgram {
    /// The infeed axis clear of everything that is made along it.
    fn rise_clear(&mut self, request: &PostRequest<'_>, of: &FeatureRequest<'_>) -> Result<(), PostError> {
        let along = request.features.iter().filter(|other| other.path.infeed == of.path.infeed);
        let clear_mm = along.map(|other| other.clear_mm).fold(f64::NEG_INFINITY, f64::max);
        let axis = NcAxis::from(of.path.infeed);
        let target = Target::default().with(axis, request.control.format.count(axis, clear_mm)?);
        self.program.main.push(Step::Block(Block::Comment(of.name.clone())));
        self.program.main.push(Step::Block(Block::Rapid(target)));
        if request.coolant && self.turns.is_empty() {
            self.program.main.push(Step::Block(Block::Coolant(true)));
        }
        Ok(())
    }

    /// Sets the path tolerance of a pass if the request has none: a multiple of the deviation of its pieces. Without it no axis could pass a
    /// corner.
    fn round_off(&mut self, request: &PostRequest<'_>, turn: usize) -> Result<(), PostError> {
        if request.control.path_tolerance_mm.is_none() {
            let count = request.control.format.count(NcAxis::Z, ROUNDED_OFF * self.turns[turn].tolerance_mm)?.max(1);
            let block = Step::Block(Block::PathTolerance(count));
            let last = self.program.main.iter().rfind(|step| matches!(step, Step::Block(Block::PathTolerance(_))));
            if last != Some(&block) {
                self.program.main.push(block);
            }
        }
        Ok(())
    }

    /// The subprogram of a pass.
    fn add_turn(&mut self, request: &PostRequest<'_>, (feature, pass): (usize, usize)) -> Result<usize, PostError> {
        let (of, of_pass) = (&request.features[feature], &request.features[feature].passes[pass]);
        let turn = SubprogramMotion::new(&request.control, of, of_pass);
        let pieces = Pieces::fitting(&turn, &request.control, of, of_pass)?;
        let format = request.control.format;
        let index = self.program.subprograms.len();
        let number = u32::try_from(index).ok().and_then(|index| request.number.checked_add(1 + index));
        let others = request.features.iter().filter(|other| other.name == of.name).count();
        let title =
            if of.passes.len() > 1 || others > 1 { format!("{} {}", of.name, of_pass.name) } else { of.name.clone() };
        let rises = Target::default()
            .with(NcAxis::from(of.path.infeed), format.count(NcAxis::from(of.path.infeed), of.clear_mm)?);
        let mut blocks = pieces.approach(&turn, format)?;
        blocks.extend(pieces.feeds());
        blocks.push(Block::Rapid(rises));
        self.program.subprograms.push(Subprogram {
            // A long name is cut off on some controls, so it is cut here, where its number keeps it apart.
            name: if title.chars().count() <= MAX_NAME {
                title.clone()
            } else {
                format!("{:.12} {}", of.name, index + 1)
            },
            title: format!("{title}: {}, {} blocks", of.path.name, pieces.blocks()),
            number: number.ok_or(PostError::TooManySubprograms { count: index })?,
            offset_axis: Some(of.path.infeed),
            blocks,
        });
        self.turns.push(pieces.into_posted((feature, pass, index)));
        Ok(self.turns.len() - 1)
    }

    /// A call of a turn, C being where it is (increments); returns where C is then.
    fn call(
        &mut self,
        request: &PostRequest<'_>,
        of: &FeatureRequest<'_>,
        turn: usize,
        leaves_mm: f64,
        c_now: i64,
    ) -> Result<i64, PostError> {
        let format = request.control.format;
        let posted = &self.turns[turn];
        let phase_rad = f64::from(request.control.rotation_sense) * of.phase_rad;
        let whole_turn = format.count(NcAxis::C, TURN_RAD)?;
        let (first, last) = (posted.knots.first(), posted.knots.last());
        let (Some(first), Some(last)) = (first, last) else { return Ok(c_now) };
        let (begins, ends) = (format.count(NcAxis::C, first.0)?, format.count(NcAxis::C, last.0)?);
        // The whole turns by which C goes on, so that it neither winds back nor turns more than half a turn to the beginning.
        let phase = format.count(NcAxis::C, phase_rad)?;
        let on = (c_now - (phase + begins) + whole_turn / 2).div_euclid(whole_turn) * whole_turn;
        if of.path.turns() > 1 && phase.rem_euclid(whole_turn) + ends >= C_INCREMENTS {
            let whole = whole_turn as f64;
            return Err(PostError::TooManyTurns {
                turns: (phase.rem_euclid(whole_turn) + ends) as f64 / whole,
                max: C_INCREMENTS as f64 / whole,
                decimals: format.decimals(NcAxis::C),
            });
        }
        // Unless the control has no digits for it: then C winds back, with the cutter clear of the part.
        let on = if phase + on + ends < C_INCREMENTS { on } else { 0 };
        let (phase, offset) = (phase + on, format.count(NcAxis::from(of.path.infeed), leaves_mm)?);
        self.program.main.push(Step::Call(Call { subprogram: posted.subprogram, phase, offset }));
        self.feed_time_s += posted.time_s;
        self.calls.push((turn, format.value(NcAxis::C, phase), leaves_mm));
        Ok(phase + ends)
    }

    /// Ends the program after the last cam: everything off, C back at zero.
    fn finish(&mut self, request: &PostRequest<'_>) -> Result<(), PostError> {
        let main = &mut self.program.main;
        if request.coolant {
            main.push(Step::Block(Block::Coolant(false)));
        }
        if request.spindle.is_some() {
            main.push(Step::Block(Block::SpindleOff));
        }
        main.push(Step::Block(Block::Rapid(
            Target::default().with(NcAxis::C, request.control.format.count(NcAxis::C, 0.0)?),
        )));
        Ok(())
    }
}
