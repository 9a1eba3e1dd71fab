// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The blocks of the main program or of one subprogram.

use super::words;
use crate::gcode::dialect::{Dialect, MAX_DWELL_MS, MAX_RPM, MAX_TOOL, Rules};
use crate::gcode::driven::shift_of;
use crate::gcode::fitted::{self, ProgramNames};
use crate::gcode::{Block, BlockLocation, Call, NcAxis, Program, Subprogram, Target, WriteError};
use alloc::format;
use alloc::string::String;

/// Largest path tolerance, in increments.
const MAX_TOLERANCE: i64 = 9_999_999;

/// Significant digits of F.
const FEED_DIGITS: i32 = 7;

pub(super) struct Section<'a> {
    dialect: Dialect,
    rules: &'static Rules,
    program: &'a Program,
    subprogram: Option<&'a Subprogram>,
    /// The block that is being written, from 1.
    block: usize,
    /// True while inverse-time feed is active.
    inverse_time: bool,
    /// The motion that a line of axes alone would mean.
    motion: Option<&'static str>,
    pub(super) text: String,
}

impl<'a> Section<'a> {
    pub(super) fn new(dialect: Dialect, program: &'a Program, subprogram: Option<&'a Subprogram>) -> Self {
        let rules = dialect.rules();
        let text = String::new();
        Self { dialect, rules, program, subprogram, block: 0, inverse_time: false, motion: None, text }
    }

    pub(super) const fn begin_block(&mut self) {
        self.block += 1;
    }

    fn place(&self) -> BlockLocation {
        BlockLocation { subprogram: self.subprogram.map(|sub| sub.name.clone()), block: self.block }
    }

    pub(super) fn block(&mut self, block: &Block) -> Result<(), WriteError> {
        match block {
            Block::Rapid(target) => self.rapid(target),
            Block::Feed { target, time_s } => self.feed(target, *time_s),
            Block::Comment(text) => {
                let text = fitted::text(self.dialect, text)?;
                words::push_comment(self.dialect, &mut self.text, &text);
                Ok(())
            }
            _ => {
                self.end_feeding();
                self.order(block)
            }
        }
    }

    /// Back from inverse times, and no motion goes on: what follows says its motion again.
    pub(super) fn end_feeding(&mut self) {
        if core::mem::take(&mut self.inverse_time) {
            self.text.push_str("G94\n");
        }
        self.motion = None;
    }

    fn rapid(&mut self, target: &Target) -> Result<(), WriteError> {
        if self.inverse_time {
            self.end_feeding();
        }
        self.axes("G0", target)?;
        self.text.push('\n');
        Ok(())
    }

    fn feed(&mut self, target: &Target, time_s: f64) -> Result<(), WriteError> {
        let feed = self.inverse_time_word(time_s)?;
        if !core::mem::replace(&mut self.inverse_time, true) {
            self.text.push_str("G93\n");
            self.motion = None;
        }
        self.axes("G1", target)?;
        self.text.push_str(&feed);
        self.text.push('\n');
        Ok(())
    }

    fn axes(&mut self, motion: &'static str, target: &Target) -> Result<(), WriteError> {
        if target.named().next().is_none() {
            return Err(WriteError::NoTarget { place: self.place() });
        }
        let mut between = "";
        if self.motion.replace(motion) != Some(motion) {
            self.text.push_str(motion);
            between = " ";
        }
        for (axis, count) in target.named() {
            let word = self.coordinate(axis, count)?;
            self.text.push_str(between);
            self.text.push_str(&word);
            between = " ";
        }
        Ok(())
    }

    fn coordinate(&self, axis: NcAxis, count: i64) -> Result<String, WriteError> {
        let word = format!("{}{}", axis.letter(), words::decimal(count, self.program.format.decimals(axis)));
        let (digits, max) = (digits_of(count), self.maximum_digits(axis));
        if digits > max {
            return Err(WriteError::TooManyDigits { place: self.place(), word, digits, max });
        }
        Ok(word)
    }

    /// Digits that the control reads of an axis, of which no more than eight stand before the point.
    fn maximum_digits(&self, axis: NcAxis) -> u32 {
        self.rules.digits.min(8 + self.program.format.decimals(axis))
    }

    /// ` F…` for a time, with so many digits that a block is as long as it was meant to be to a ten-millionth.
    fn inverse_time_word(&self, time_s: f64) -> Result<String, WriteError> {
        if !(time_s > 0.0 && time_s.is_finite()) {
            return Err(WriteError::NoTime { place: self.place(), time_s });
        }
        let feed_per_min = 60.0 / time_s;
        let (min, max, decimals) = self.rules.feed;
        if !(min..=max).contains(&feed_per_min) {
            return Err(WriteError::FeedOutOfRange { place: self.place(), feed_per_min, time_s, min, max });
        }
        #[allow(clippy::cast_possible_truncation, reason = "the logarithm of a number within the range of feeds")]
        let before = libm::floor(libm::log10(feed_per_min)) as i32 + 1;
        let wanted = usize::try_from(FEED_DIGITS - before).unwrap_or(0).clamp(1, decimals);
        let number = format!("{feed_per_min:.wanted$}");
        let number = number.trim_end_matches('0');
        Ok(format!(" F{number}{}", if number.ends_with('.') { "0" } else { "" }))
    }

    /// Writes a block that is neither motion nor comment.
    fn order(&mut self, block: &Block) -> Result<(), WriteError> {
        let place = || self.place();
        let line = match block {
            Block::ToolChange(number) => {
                let number = *number;
                if !self.program.tools.iter().any(|tool| tool.number == number && number <= MAX_TOOL) {
                    return Err(WriteError::UnknownTool { place: place(), number });
                }
                words::tool_change(self.dialect, number)
            }
            Block::SpindleOn { direction, rpm } => {
                if !(1..=MAX_RPM).contains(rpm) {
                    return Err(WriteError::SpindleSpeed { place: place(), rpm: *rpm, max: MAX_RPM });
                }
                format!("S{rpm} {}\n", direction.code())
            }
            Block::SpindleOff => "M5\n".into(),
            Block::Coolant(on) => if *on { "M8\n" } else { "M9\n" }.into(),
            Block::PathTolerance(increments) => {
                if !(1..=MAX_TOLERANCE).contains(increments) {
                    let (increments, max) = (*increments, MAX_TOLERANCE);
                    return Err(WriteError::Tolerance { place: place(), increments, max });
                }
                words::path_tolerance(
                    self.dialect,
                    &words::decimal(*increments, self.program.format.decimals(NcAxis::Z)),
                )
            }
            Block::Dwell { ms } => {
                if !(1..=MAX_DWELL_MS).contains(ms) {
                    return Err(WriteError::Dwell { place: place(), ms: *ms, max: MAX_DWELL_MS });
                }
                words::dwell(self.dialect, &words::decimal(i64::from(*ms), 3))
            }
            Block::Comment(_) | Block::Rapid(_) | Block::Feed { .. } => return Ok(()),
        };
        self.text.push_str(&line);
        Ok(())
    }

    pub(super) fn call(&mut self, call: &Call, names: &ProgramNames) -> Result<(), WriteError> {
        self.end_feeding();
        let count = self.program.subprograms.len();
        let Some(sub) = self.program.subprograms.get(call.subprogram) else {
            return Err(WriteError::NoSuchSubprogram { place: self.place(), index: call.subprogram, count });
        };
        if sub.offset_axis.is_none() && call.offset != 0 {
            let subprogram = sub.name.clone();
            return Err(WriteError::OffsetOfNoAxis { place: self.place(), offset: call.offset, subprogram });
        }
        self.check_shifted(call, sub)?;
        words::push_call(self.dialect, &mut self.text, self.program.format, names, call, sub);
        Ok(())
    }

    /// Checks that the shifted coordinates of a subprogram stay within the control's digits.
    fn check_shifted(&self, call: &Call, sub: &Subprogram) -> Result<(), WriteError> {
        let shift = shift_of(self.program, call);
        let targets = sub.blocks.iter().filter_map(|block| match block {
            Block::Rapid(target) | Block::Feed { target, .. } => Some(target),
            _ => None,
        });
        for (axis, by) in shift.named() {
            let counts = targets.clone().filter_map(|target| target.value(axis));
            let longest = counts.map(|count| digits_of(count.saturating_add(by))).max().unwrap_or(0);
            let (digits, max) = (longest.max(digits_of(by)), self.maximum_digits(axis));
            if digits > max {
                return Err(WriteError::ShiftedTooFar { place: self.place(), axis, digits, max });
            }
        }
        Ok(())
    }
}

fn digits_of(count: i64) -> u32 {
    count.unsigned_abs().checked_ilog10().map_or(1, |power| power + 1)
}
