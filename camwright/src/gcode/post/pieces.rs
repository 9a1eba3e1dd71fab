// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The turn of a call in whole increments: chains of pieces, rounded, judged as they will be driven, and slow enough for the control.

use super::turn::SubprogramMotion;
use super::{FeatureRequest, NcControl, PassRequest, PostError, PostedTurn};
use crate::gcode::archimedean::{Chain, ChainDeviation, ChainRequest, Travelling, theoretical_pieces};
use crate::gcode::{Block, Dialect, MIN_RATE_MM_MIN, NcAxis, NumberFormat, Target};
use crate::math::units::{rpm_from_rad_s, um_from_mm};
use crate::toolpath::cutter_path::CarriageAxis;
use alloc::vec::Vec;

/// Growth of the tolerance from one attempt to the next if blocks come too fast.
pub(super) const WIDER: f64 = 1.1;

/// Blocks over which their rate is taken: a control reads some ahead.
const RATE_OVER: usize = 10;

/// Factor on a printed speed, so that the rounded value still keeps the limit.
pub(super) const ROUNDED_DOWN: f64 = 0.999;

/// Looks per turn for the steepest travel.
const LOOKS_PER_TURN: u32 = 720;

/// Places at which the path is compared with a chord that may be made level, and share of the tolerance it may use: all of it is judged
/// afterwards.
const LOOKS_PER_PIECE: u32 = 32;
const LEVEL_SHARE: f64 = 0.9;

/// A block in which a linear axis moves by its last increment while C turns on takes this share of what LinuxCNC's least rate allows.
const STEP_SHARE: f64 = 0.8;

/// Most blocks of one turn: the shipped programs have up to some thousand, and controls hold programs of some megabytes.
const MAX_TURN_BLOCKS: u64 = 100_000;

/// A knot in increments.
#[derive(Debug, Clone, PartialEq)]
struct RoundedKnot {
    c: i64,
    /// The axes that move, in the order of [`SubprogramMotion::axes`].
    positions: Vec<i64>,
}

/// A stretch of a turn.
struct BlockRun {
    /// Places in the list of knots of the whole turn, the last one included.
    from: usize,
    to: usize,
    /// Indices of the moving axes.
    moving: Vec<usize>,
}

/// A turn in pieces.
pub(super) struct Pieces {
    axes: Vec<CarriageAxis>,
    knots: Vec<RoundedKnot>,
    stretches: Vec<BlockRun>,
    times_s: Vec<f64>,
    tolerance_mm: f64,
    deviation: ChainDeviation,
    velocity_step_mm_s: f64,
    pieces_of_turn: usize,
    lengthened: usize,
    theoretical: f64,
    blocks_s: f64,
    format: NumberFormat,
}

impl Pieces {
    /// The fewest pieces within the tolerance, or within a wider one where the control would not read them in time.
    pub(super) fn fitting(
        turn: &SubprogramMotion<'_>,
        control: &NcControl,
        of: &FeatureRequest<'_>,
        pass: &PassRequest<'_>,
    ) -> Result<Self, PostError> {
        let mut tolerance_mm = pass.tolerance_mm;
        loop {
            // Level pieces and wide steps where the tolerance has room for them, else steps of an increment.
            let attempt = Self::new(turn, control, pass, tolerance_mm, true);
            let attempt = match attempt {
                Err(PostError::OffThePath { .. }) => Self::new(turn, control, pass, tolerance_mm, false),
                other => other,
            };
            let mut pieces = attempt.map_err(|error| error.within(&of.name, &pass.name))?;
            let min_s = control.dialect.shortest_block_s();
            let is_last = tolerance_mm >= pass.widest_tolerance_mm;
            if is_last {
                pieces.lengthen(min_s);
            }
            let all_long = pieces.times_s.iter().all(|time_s| *time_s >= min_s);
            if pieces.blocks_s <= control.max_blocks_s && all_long {
                return Ok(pieces);
            }
            if is_last {
                let slower = control.max_blocks_s / pieces.blocks_s;
                return Err(PostError::TooManyBlocks {
                    feature: of.name.clone(),
                    pass: pass.name.clone(),
                    blocks_s: pieces.blocks_s,
                    max_s: control.max_blocks_s,
                    tolerance_um: um_from_mm(tolerance_mm),
                    fits_rpm: rpm_from_rad_s(ROUNDED_DOWN * slower * turn.speed_rad_s(turn.begin_rad)),
                });
            }
            tolerance_mm = (tolerance_mm * WIDER).min(pass.widest_tolerance_mm);
        }
    }

    fn new(
        turn: &SubprogramMotion<'_>,
        control: &NcControl,
        pass: &PassRequest<'_>,
        tolerance_mm: f64,
        widely: bool,
    ) -> Result<Self, PostError> {
        let axes = turn.axes();
        let mut pieces = Self {
            axes,
            knots: Vec::new(),
            stretches: Vec::new(),
            times_s: Vec::new(),
            tolerance_mm,
            deviation: ChainDeviation::default(),
            velocity_step_mm_s: 0.0,
            pieces_of_turn: 0,
            lengthened: 0,
            theoretical: 0.0,
            blocks_s: 0.0,
            format: control.format,
        };
        let rounding_mm = pieces.rounding_mm(turn, control);
        for (index, (from_rad, to_rad)) in turn.stretches().into_iter().enumerate() {
            let leading = index != 1;
            let moving: Vec<usize> =
                (0..pieces.axes.len()).filter(|axis| turn.moves(pieces.axes[*axis], leading)).collect();
            let travels: Vec<_> = moving
                .iter()
                .map(|axis| {
                    let axis = pieces.axes[*axis];
                    move |u_rad: f64| turn.at(axis, u_rad)
                })
                .collect();
            let travels: Vec<Travelling<'_>> = travels.iter().map(|travel| travel as Travelling<'_>).collect();
            let request =
                ChainRequest { travels: &travels, from_rad, to_rad, tolerance_mm, rounding_mm, knots: pass.knots };
            pieces.add_stretch(turn, &Chain::new(&request)?, moving, control.dialect.longest_block_s())?;
            if !leading {
                pieces.theoretical = theoretical_pieces(&request)?;
                pieces.pieces_of_turn = pieces.stretches.last().map_or(0, |stretch| stretch.to - stretch.from);
            }
        }
        if control.dialect == Dialect::LinuxCnc {
            pieces.step_slowly(turn, widely)?;
        }
        pieces.time(turn);
        pieces.judge(turn, pass)?;
        Ok(pieces)
    }

    /// Share of the tolerance (mm) used by rounding of both ends of a piece, and on LinuxCNC by the steps of very slow pieces.
    fn rounding_mm(&self, turn: &SubprogramMotion<'_>, control: &NcControl) -> f64 {
        let last_digit = |axis| control.format.value(axis, 1);
        let looks = LOOKS_PER_TURN * turn.turns_of_path();
        let steepest = self.axes.iter().flat_map(|axis| {
            (0..looks).map(|look| {
                let u_rad = turn.begin_rad + (turn.full_rad - turn.begin_rad) * f64::from(look) / f64::from(looks);
                turn.at(*axis, u_rad).first.abs()
            })
        });
        let steepest = steepest.fold(0.0, f64::max);
        let half_mm = 0.5 * last_digit(NcAxis::Z).max(last_digit(NcAxis::X));
        let steps_mm = if control.dialect == Dialect::LinuxCnc { half_mm } else { 0.0 };
        half_mm + steps_mm + 0.5 * last_digit(NcAxis::C) * steepest
    }

    /// Knots of a chain in increments, after those that are there; ends meet. A piece that takes longer than a block can is several.
    fn add_stretch(
        &mut self,
        turn: &SubprogramMotion<'_>,
        chain: &Chain,
        moving: Vec<usize>,
        longest_s: f64,
    ) -> Result<(), PostError> {
        let from = self.knots.len().saturating_sub(1);
        let mut before_rad = None;
        for (knot, u_rad) in chain.angles_rad.iter().enumerate() {
            if let Some(before_rad) = before_rad {
                let time_s = turn.time_s(before_rad, *u_rad);
                let max_s = if time_s > longest_s { ROUNDED_DOWN * longest_s } else { longest_s };
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of blocks")]
                let blocks = libm::ceil(time_s / max_s).clamp(1.0, 1e9) as u32;
                if u64::from(blocks) > MAX_TURN_BLOCKS {
                    return Err(PostError::TooLongTurn { blocks: u64::from(blocks), allowed: MAX_TURN_BLOCKS });
                }
                for block in 1..blocks {
                    let share = f64::from(block) / f64::from(blocks);
                    let position_mm = |place: usize| {
                        let positions_mm: &[f64] = &chain.positions_mm[place];
                        positions_mm[knot - 1] + share * (positions_mm[knot] - positions_mm[knot - 1])
                    };
                    self.add_knot(turn, before_rad + share * (*u_rad - before_rad), position_mm, &moving)?;
                }
            }
            self.add_knot(turn, *u_rad, |place| chain.positions_mm[place][knot], &moving)?;
            before_rad = Some(*u_rad);
        }
        self.stretches.push(BlockRun { from, to: self.knots.len() - 1, moving });
        Ok(())
    }

    /// A knot in increments, with the positions of the axes that move.
    fn add_knot(
        &mut self,
        turn: &SubprogramMotion<'_>,
        u_rad: f64,
        position_mm: impl Fn(usize) -> f64,
        moving: &[usize],
    ) -> Result<(), PostError> {
        let format = self.format;
        let c = format.count(NcAxis::C, u_rad)?;
        let mut positions = Vec::with_capacity(self.axes.len());
        for (index, axis) in self.axes.iter().enumerate() {
            let position_mm = match moving.iter().position(|moves| *moves == index) {
                Some(place) => position_mm(place),
                None => turn.at(*axis, u_rad).value,
            };
            positions.push(format.count(NcAxis::from(*axis), position_mm)?);
        }
        // Two knots that C cannot resolve are one; the first and the last knot of a run lie on the path.
        match self.knots.last_mut() {
            Some(last) if last.c == c => last.positions = positions,
            _ => self.knots.push(RoundedKnot { c, positions }),
        }
        Ok(())
    }

    /// LinuxCNC makes a rate of the time by the linear way, none below a least one. What is slower is driven level, as one block of C
    /// alone, where the path stays within the tolerance of that, else as steps as wide as the tolerance allows, each in a short block in
    /// which C turns on, with C alone between them. Not `widely`: as steps of an increment.
    fn step_slowly(&mut self, turn: &SubprogramMotion<'_>, widely: bool) -> Result<(), PostError> {
        let format = self.format;
        // Where stretches meet, and at the end, knots lie on the path.
        let mut is_end = alloc::vec![false; self.knots.len()];
        for stretch in &self.stretches {
            (is_end[stretch.from], is_end[stretch.to]) = (true, true);
        }
        let mut knots: Vec<RoundedKnot> = Vec::with_capacity(self.knots.len());
        let mut places = alloc::vec![0; self.knots.len()];
        for (index, knot) in self.knots.iter().enumerate() {
            if let Some(last) = knots.last().cloned() {
                let (u, v) = (format.value(NcAxis::C, last.c), format.value(NcAxis::C, knot.c));
                let time_s = turn.time_s(u, v);
                let way_mm = self.distance_mm(&last, knot);
                if way_mm > 0.0 && way_mm * 60.0 / time_s < MIN_RATE_MM_MIN * 1.001 {
                    let level = RoundedKnot { c: knot.c, positions: last.positions.clone() };
                    let next = self.knots.get(index + 1).filter(|_| widely && !is_end[index]);
                    if next.is_some_and(|next| {
                        self.room_mm(turn, &last, &level) >= 0.0 && self.room_mm(turn, &level, next) >= 0.0
                    }) {
                        knots.push(level);
                        places[index] = knots.len() - 1;
                        continue;
                    }
                    let room_mm = if widely { self.room_mm(turn, &last, knot) } else { 0.0 };
                    self.add_steps(turn, (&last, knot), room_mm, &mut knots)?;
                }
            }
            knots.push(knot.clone());
            places[index] = knots.len() - 1;
        }
        for stretch in &mut self.stretches {
            (stretch.from, stretch.to) = (places[stretch.from], places[stretch.to]);
        }
        self.knots = knots;
        Ok(())
    }

    /// Tolerance left beside a chord (mm): below 0 the path goes farther from it than that.
    fn room_mm(&self, turn: &SubprogramMotion<'_>, from: &RoundedKnot, to: &RoundedKnot) -> f64 {
        let (begins, ends) = (self.format.value(NcAxis::C, from.c), self.format.value(NcAxis::C, to.c));
        let mut farthest_mm = 0.0_f64;
        for (index, axis) in self.axes.iter().enumerate() {
            let value = |knot: &RoundedKnot| self.format.value(NcAxis::from(*axis), knot.positions[index]);
            let (at_begin, at_end) = (value(from), value(to));
            for look in 0..=LOOKS_PER_PIECE {
                let share = f64::from(look) / f64::from(LOOKS_PER_PIECE);
                let path = turn.at(*axis, begins + (ends - begins) * share).value;
                farthest_mm = farthest_mm.max((path - (at_begin + (at_end - at_begin) * share)).abs());
            }
        }
        LEVEL_SHARE * self.tolerance_mm - farthest_mm
    }

    /// The knots between two ends of a slow piece, in steps of half of which there is so much room beside the chord (mm).
    fn add_steps(
        &self,
        turn: &SubprogramMotion<'_>,
        (from, to): (&RoundedKnot, &RoundedKnot),
        room_mm: f64,
        knots: &mut Vec<RoundedKnot>,
    ) -> Result<(), PostError> {
        let ways: Vec<i64> = from.positions.iter().zip(&to.positions).map(|(a, b)| b - a).collect();
        let increments = ways.iter().map(|way| way.abs()).max().unwrap_or(0);
        let min_mm =
            self.axes.iter().map(|axis| self.format.value(NcAxis::from(*axis), 1)).fold(f64::INFINITY, f64::min);
        #[allow(clippy::cast_possible_truncation, reason = "a tolerance in increments")]
        let wide = ((2.0 * room_mm.max(0.0) / min_mm) as i64).clamp(1, increments.max(1));
        let steps = (increments + wide - 1) / wide;
        let knots_wanted =
            u64::try_from(steps).unwrap_or(u64::MAX).saturating_mul(2).saturating_add(knots.len() as u64);
        if knots_wanted > MAX_TURN_BLOCKS {
            return Err(PostError::TooLongTurn { blocks: knots_wanted, allowed: MAX_TURN_BLOCKS });
        }
        // What the smallest of them goes: none is slower than the least rate.
        let of_step = (increments / steps.max(1)).max(1);
        let step_s = STEP_SHARE * min_mm * of_step as f64 * 60.0 / MIN_RATE_MM_MIN;
        let (begins, ends) = (self.format.value(NcAxis::C, from.c), self.format.value(NcAxis::C, to.c));
        let position = |step: i64| -> Vec<i64> {
            // Rounded to the nearest: division cuts towards zero.
            let at = |start: &i64, way: &i64| start + (2 * way * step + steps * way.signum()) / (2 * steps);
            from.positions.iter().zip(&ways).map(|(start, way)| at(start, way)).collect()
        };
        for step in 0..steps {
            // In the middle of its share of the angle, so that it is half an increment off on either side.
            let middle = begins + (ends - begins) * (step as f64 + 0.5) / steps as f64;
            let half = 0.5 * step_s * turn.speed_rad_s(middle);
            for (u_rad, positions) in [(middle - half, position(step)), (middle + half, position(step + 1))] {
                let c = self.format.count(NcAxis::C, u_rad.clamp(begins, ends))?;
                if c < to.c && knots.last().is_some_and(|last| last.c < c) {
                    knots.push(RoundedKnot { c, positions });
                }
            }
        }
        Ok(())
    }

    /// Linear way from a knot to another (mm).
    fn distance_mm(&self, from: &RoundedKnot, to: &RoundedKnot) -> f64 {
        let square = |(index, axis): (usize, &CarriageAxis)| {
            let way = self.format.value(NcAxis::from(*axis), to.positions[index] - from.positions[index]);
            way * way
        };
        libm::sqrt(self.axes.iter().enumerate().map(square).sum::<f64>())
    }

    /// The time of every block, and how many of them there are in a second.
    fn time(&mut self, turn: &SubprogramMotion<'_>) {
        let angle = |knot: &RoundedKnot| self.format.value(NcAxis::C, knot.c);
        self.times_s = self.knots.windows(2).map(|pair| turn.time_s(angle(&pair[0]), angle(&pair[1]))).collect();
        self.count_rate();
    }

    fn count_rate(&mut self) {
        self.blocks_s = blocks_per_second(&self.times_s);
    }

    /// Blocks that the control's format has no time for take as long as it has.
    fn lengthen(&mut self, min_s: f64) {
        for time_s in &mut self.times_s {
            if *time_s < min_s {
                *time_s = min_s;
                self.lengthened += 1;
            }
        }
        self.count_rate();
    }

    /// The knots of a stretch as they will be driven, as a chain of the axes that move in it.
    fn chain(&self, stretch: &BlockRun) -> Chain {
        let knots = &self.knots[stretch.from..=stretch.to];
        let positions = |axis: &usize| {
            let of = NcAxis::from(self.axes[*axis]);
            knots.iter().map(|knot| self.format.value(of, knot.positions[*axis])).collect()
        };
        Chain {
            angles_rad: knots.iter().map(|knot| self.format.value(NcAxis::C, knot.c)).collect(),
            positions_mm: stretch.moving.iter().map(positions).collect(),
        }
    }

    /// Judges what will be driven, in increments, against the path.
    fn judge(&mut self, turn: &SubprogramMotion<'_>, pass: &PassRequest<'_>) -> Result<(), PostError> {
        let mut worst = ChainDeviation::default();
        for (stretch, (from_rad, to_rad)) in self.stretches.iter().zip(turn.stretches()) {
            let travels: Vec<_> = stretch
                .moving
                .iter()
                .map(|axis| {
                    let axis = self.axes[*axis];
                    move |u_rad: f64| turn.at(axis, u_rad)
                })
                .collect();
            let travels: Vec<Travelling<'_>> = travels.iter().map(|travel| travel as Travelling<'_>).collect();
            let request = ChainRequest {
                travels: &travels,
                from_rad,
                to_rad,
                tolerance_mm: self.tolerance_mm,
                rounding_mm: 0.0,
                knots: pass.knots,
            };
            let found = self.chain(stretch).judge(&request)?;
            if found.error_mm > worst.error_mm || found.error_mm.is_nan() {
                (worst.error_mm, worst.error_at_rad) = (found.error_mm, found.error_at_rad);
                worst.error_axis = stretch.moving[found.error_axis];
            }
        }
        let whole = BlockRun { from: 0, to: self.knots.len() - 1, moving: (0..self.axes.len()).collect() };
        let chain = self.chain(&whole);
        for axis in 0..self.axes.len() {
            for piece in 1..chain.pieces() {
                let jump = (chain.slope(axis, piece) - chain.slope(axis, piece - 1)).abs();
                let at_rad = chain.angles_rad[piece];
                self.velocity_step_mm_s = self.velocity_step_mm_s.max(jump * turn.speed_rad_s(at_rad));
                if jump > worst.slope_jump_mm_rad {
                    (worst.slope_jump_mm_rad, worst.slope_axis, worst.slope_at_rad) = (jump, axis, at_rad);
                }
            }
        }
        self.deviation = worst;
        if worst.error_mm > self.tolerance_mm || worst.error_mm.is_nan() {
            return Err(PostError::OffThePath {
                error_um: um_from_mm(worst.error_mm),
                allowed_um: um_from_mm(self.tolerance_mm),
                at_deg: crate::math::units::deg_from_rad(worst.error_at_rad),
            });
        }
        Ok(())
    }

    /// Blocks in which something feeds.
    pub(super) fn blocks(&self) -> usize {
        self.times_s.len()
    }

    /// To the beginning: everything but the infeed axis, then that.
    pub(super) fn approach(&self, turn: &SubprogramMotion<'_>, format: NumberFormat) -> Result<Vec<Block>, PostError> {
        let Some(first) = self.knots.first() else { return Ok(Vec::new()) };
        let (mut beside, mut towards) = (Target::default().with(NcAxis::C, first.c), Target::default());
        for (index, axis) in self.axes.iter().enumerate() {
            let (of, count) = (NcAxis::from(*axis), first.positions[index]);
            if *axis == turn.infeed() { towards = towards.with(of, count) } else { beside = beside.with(of, count) }
        }
        for (axis, stands_mm) in turn.standing() {
            beside = beside.with(NcAxis::from(axis), format.count(NcAxis::from(axis), stands_mm)?);
        }
        Ok(alloc::vec![Block::Rapid(beside), Block::Rapid(towards)])
    }

    /// Its blocks: an axis that stays is not named.
    pub(super) fn feeds(&self) -> impl Iterator<Item = Block> + '_ {
        self.knots.windows(2).zip(&self.times_s).map(|(pair, time_s)| {
            let mut target = Target::default().with(NcAxis::C, pair[1].c);
            for (index, axis) in self.axes.iter().enumerate() {
                if pair[1].positions[index] != pair[0].positions[index] {
                    target = target.with(NcAxis::from(*axis), pair[1].positions[index]);
                }
            }
            Block::Feed { target, time_s: *time_s }
        })
    }

    /// Result for the report; (feature, pass, subprogram) locate the turn.
    pub(super) fn into_posted(self, (feature, pass, subprogram): (usize, usize, usize)) -> PostedTurn {
        let value = |knot: &RoundedKnot| {
            let positions = self.axes.iter().zip(&knot.positions);
            let positions = positions.map(|(axis, count)| self.format.value(NcAxis::from(*axis), *count)).collect();
            (self.format.value(NcAxis::C, knot.c), positions)
        };
        PostedTurn {
            feature,
            pass,
            subprogram,
            tolerance_mm: self.tolerance_mm,
            deviation: self.deviation,
            pieces_of_turn: self.pieces_of_turn,
            theoretical_pieces: self.theoretical,
            blocks: self.times_s.len(),
            lengthened: self.lengthened,
            blocks_s: self.blocks_s,
            velocity_step_mm_s: self.velocity_step_mm_s,
            time_s: self.times_s.iter().sum(),
            knots: self.knots.iter().map(value).collect(),
            axes: self.axes.clone(),
        }
    }
}

/// Most blocks in a second, over some of them.
pub(super) fn blocks_per_second(times_s: &[f64]) -> f64 {
    let over = RATE_OVER.min(times_s.len()).max(1);
    let rate = |window: &[f64]| window.len() as f64 / window.iter().sum::<f64>();
    times_s.windows(over).map(rate).fold(0.0, f64::max)
}
