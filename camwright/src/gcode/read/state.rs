// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Modal state between blocks, and execution of a block.

use super::block::{Group, ReadBlock, word};
use super::number::Fixed;
use super::{Dialect, ReadFault};
use crate::gcode::{Direction, MotionAction, NcAxis, ProgramPose, XValues};
use crate::math::units::rad_from_deg;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Next line after a block.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Flow {
    Next,
    Call(String, Vec<Fixed>),
    Return,
    End,
}

/// A motion that holds for blocks of axes alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MotionMode {
    Rapid,
    Feed,
}

#[derive(Debug)]
pub(super) struct ModalState {
    dialect: Dialect,
    motion: Option<MotionMode>,
    metric: bool,
    absolute: bool,
    inverse_time: bool,
    diameter: bool,
    shift: [Fixed; 4],
    pose: ProgramPose,
    speed: Option<Fixed>,
    selected: Option<u32>,
    mounted: Option<u32>,
}

const AXES: [(NcAxis, u8); 4] = [(NcAxis::X, b'X'), (NcAxis::Y, b'Y'), (NcAxis::Z, b'Z'), (NcAxis::C, b'C')];

fn needs(word: &str, needs: &'static str) -> ReadFault {
    ReadFault::Needs { word: word.into(), needs }
}

fn refuse(word: impl Into<String>, why: &'static str) -> ReadFault {
    ReadFault::Refused { word: word.into(), why }
}

impl ModalState {
    pub(super) fn new(dialect: Dialect, x_values: XValues) -> Self {
        Self {
            dialect,
            motion: None,
            metric: false,
            absolute: false,
            inverse_time: false,
            diameter: x_values == XValues::Diameter,
            shift: [Fixed::ZERO; 4],
            pose: ProgramPose::default(),
            speed: None,
            selected: None,
            mounted: None,
        }
    }

    /// Executes a block in the order that controls use, independent of the order of its words.
    pub(super) fn execute(
        &mut self,
        block: &mut ReadBlock,
        done: &mut impl FnMut(MotionAction),
    ) -> Result<Flow, ReadFault> {
        self.modes(block);
        self.tool_and_spindle(block, done)?;
        self.path(block, done)?;
        let has_own_words = block.has(Group::Once) || block.name.is_some();
        let mut flow = self.once(block, done)?;
        if let Some((name, values)) = block.name.take() {
            flow = self.named(block, name, values)?;
        }
        if !has_own_words {
            self.travel(block, done)?;
        }
        let end = match block.take_code(Group::End) {
            Some(980) => {
                let number =
                    block.whole(b'P', 1, 99_999_999)?.ok_or_else(|| needs("M98", "P with a program's number"))?;
                Some(Flow::Call(format!("{number}"), Vec::new()))
            }
            Some(170 | 990) => Some(Flow::Return),
            Some(_) => Some(Flow::End),
            None => None,
        };
        if let Some(word) = block.left() {
            return Err(ReadFault::UnknownWord { word });
        }
        match (end, flow) {
            (Some(end), Flow::Next) => Ok(end),
            (None, flow) => Ok(flow),
            (Some(_), _) => Err(refuse("the block", "it calls and ends, or calls twice")),
        }
    }

    fn modes(&mut self, block: &mut ReadBlock) {
        if let Some(code) = block.take_code(Group::FeedMode) {
            self.inverse_time = code == 930;
        }
        self.metric |= block.take_code(Group::Units).is_some();
        self.absolute |= block.take_code(Group::Distance).is_some();
        if let Some(code) = block.take_code(Group::XValues) {
            self.diameter = code == 70;
        }
        // Planes are those of arcs, compensation is off, and the zero point is that of G54: nothing else is read.
        for group in [Group::Plane, Group::CutterRadius, Group::Zero] {
            block.take_code(group);
        }
    }

    fn tool_and_spindle(
        &mut self,
        block: &mut ReadBlock,
        done: &mut impl FnMut(MotionAction),
    ) -> Result<(), ReadFault> {
        if let Some(speed) = block.value(b'S') {
            if !speed.is_positive() {
                return Err(refuse(format!("S{speed}"), "a spindle speed must be positive"));
            }
            self.speed = Some(speed);
        }
        self.selected = block.whole(b'T', 1, 9_999)?.or(self.selected);
        if block.take_code(Group::ToolChange).is_some() {
            let tool = self.selected.ok_or_else(|| needs("M6", "a tool: T before it or in the same block"))?;
            self.mounted = Some(tool);
            done(MotionAction::ToolChange(tool));
        }
        match block.take_code(Group::Spindle) {
            Some(50) => done(MotionAction::SpindleOff),
            Some(code) => {
                let speed =
                    self.speed.ok_or_else(|| needs(&word('M', code), "a speed: S before it or in the same block"))?;
                let direction = if code == 30 { Direction::Clockwise } else { Direction::Counterclockwise };
                done(MotionAction::SpindleOn { direction, rpm: speed.value() });
            }
            None => {}
        }
        if let Some(code) = block.take_code(Group::Coolant) {
            done(MotionAction::Coolant(code == 80));
        }
        self.tool_length(block)
    }

    fn tool_length(&self, block: &mut ReadBlock) -> Result<(), ReadFault> {
        if self.dialect == Dialect::Siemens {
            block.whole(b'D', 1, 1)?;
        }
        if block.take_code(Group::ToolLength) != Some(430) {
            return Ok(());
        }
        let mounted = self.mounted.ok_or_else(|| needs("G43", "a tool: M6 before it"))?;
        match block.whole(b'H', 1, 9_999)? {
            Some(length) if length != mounted => Err(refuse(format!("H{length}"), "the length of another tool")),
            None if self.dialect == Dialect::Fanuc => Err(needs("G43", "H with the number of the tool")),
            _ => Ok(()),
        }
    }

    fn path(&self, block: &mut ReadBlock, done: &mut impl FnMut(MotionAction)) -> Result<(), ReadFault> {
        if block.take_code(Group::Path).is_none() {
            return Ok(());
        }
        let tolerance = match self.dialect {
            Dialect::Siemens => block.tolerance.take(),
            _ => {
                if block.value(b'Q').is_some_and(|within| within != Fixed::ZERO) {
                    return Err(refuse("Q", "blocks within a tolerance would be replaced by one; only Q0 is read"));
                }
                block.value(b'P')
            }
        };
        if tolerance.is_some_and(|tolerance| !tolerance.is_positive()) {
            return Err(refuse("the path tolerance", "it must be positive"));
        }
        done(MotionAction::PathTolerance(tolerance.map(Fixed::value)));
        Ok(())
    }

    /// Executes the non-modal code of a block.
    fn once(&mut self, block: &mut ReadBlock, done: &mut impl FnMut(MotionAction)) -> Result<Flow, ReadFault> {
        match block.take_code(Group::Once) {
            Some(40) => done(MotionAction::Dwell(self.pause_s(block)?)),
            Some(520) if !self.take_shifts(block)? => return Err(needs("G52", "an axis")),
            Some(921) => self.shift = [Fixed::ZERO; 4],
            Some(51) => {
                let on = block.whole(b'Q', 0, 1)?.ok_or_else(|| needs("G5.1", "Q0 or Q1"))?;
                if on == 1 {
                    done(MotionAction::PathTolerance(None));
                }
            }
            Some(650) => {
                let number =
                    block.whole(b'P', 1, 99_999_999)?.ok_or_else(|| needs("G65", "P with a program's number"))?;
                let first = block.pointed(self.dialect, b'A')?;
                let second = block.pointed(self.dialect, b'B')?;
                if first.is_none() && second.is_some() {
                    return Err(needs("B", "A in the same block"));
                }
                return Ok(Flow::Call(format!("{number}"), first.into_iter().chain(second).collect()));
            }
            _ => {}
        }
        Ok(Flow::Next)
    }

    fn pause_s(&self, block: &mut ReadBlock) -> Result<f64, ReadFault> {
        let pause = match self.dialect {
            Dialect::LinuxCnc => block.value(b'P'),
            Dialect::Fanuc => block.pointed(self.dialect, b'X')?,
            Dialect::Siemens => block.value(b'F'),
        };
        match pause {
            Some(pause) if pause.is_positive() => Ok(pause.value()),
            _ => Err(needs("G4", "a positive time in seconds")),
        }
    }

    /// Shifts of the axes that a block names; whether there were any.
    fn take_shifts(&mut self, block: &mut ReadBlock) -> Result<bool, ReadFault> {
        let mut any = false;
        for (axis, letter) in AXES {
            let Some(shift) = block.pointed(self.dialect, letter)? else { continue };
            if self.dialect == Dialect::Siemens && axis == NcAxis::X && self.diameter {
                let why = "whether a shift of X is a diameter depends on the control; DIAMOF is needed before it";
                return Err(refuse("TRANS", why));
            }
            self.shift[axis.index()] = self.as_radius(axis, shift);
            any = true;
        }
        Ok(any)
    }

    const fn as_radius(&self, axis: NcAxis, value: Fixed) -> Fixed {
        if self.diameter && matches!(axis, NcAxis::X) { value.half() } else { value }
    }

    /// Words of several letters.
    fn named(&mut self, block: &mut ReadBlock, name: String, values: Vec<Fixed>) -> Result<Flow, ReadFault> {
        match name.as_str() {
            "TRANS" => {
                self.shift = [Fixed::ZERO; 4];
                self.take_shifts(block)?;
            }
            "DIAMON" => self.diameter = true,
            "DIAMOF" => self.diameter = false,
            // No cycle holds: none is read.
            "MCALL" => {}
            "RET" => return Ok(Flow::Return),
            _ => return Ok(Flow::Call(name, values)),
        }
        if values.is_empty() { Ok(Flow::Next) } else { Err(ReadFault::UnknownWord { word: name }) }
    }

    fn travel(&mut self, block: &mut ReadBlock, done: &mut impl FnMut(MotionAction)) -> Result<(), ReadFault> {
        let stated = block.take_code(Group::Motion);
        match stated {
            Some(0) => self.motion = Some(MotionMode::Rapid),
            Some(10) => self.motion = Some(MotionMode::Feed),
            Some(_) => self.motion = None,
            None => {}
        }
        let mut pose = self.pose;
        let mut any = false;
        for (axis, letter) in AXES {
            let Some(value) = block.pointed(self.dialect, letter)? else { continue };
            let place = self.as_radius(axis, value).plus(self.shift[axis.index()]).value();
            pose = pose.with(axis, if axis == NcAxis::C { rad_from_deg(place) } else { place });
            any = true;
        }
        if !any {
            if let Some(word) = block.left().filter(|_| stated.is_some()) {
                return Err(ReadFault::UnknownWord { word });
            }
            let word = stated.filter(|code| *code != 800).map(|code| word('G', code));
            return word.map_or(Ok(()), |word| Err(needs(&word, "an axis")));
        }
        if !(self.metric && self.absolute) {
            return Err(needs("a motion", "metric and absolute coordinates, stated before it"));
        }
        let action = match self.motion.ok_or_else(|| needs("a target", "G0 or G1"))? {
            MotionMode::Rapid => MotionAction::Rapid(pose),
            MotionMode::Feed => MotionAction::Feed { pose, time_s: self.time_s(block)? },
        };
        self.pose = pose;
        done(action);
        Ok(())
    }

    fn time_s(&self, block: &mut ReadBlock) -> Result<f64, ReadFault> {
        if !self.inverse_time {
            let why = "what a feed in mm/min means for C differs from control to control; G93 is needed";
            return Err(refuse("G1", why));
        }
        let feed = block.pointed(self.dialect, b'F')?;
        let feed = feed.ok_or_else(|| needs("G1", "an F of its own: with G93 it holds for one block"))?;
        if feed.is_positive() {
            Ok(60.0 / feed.value())
        } else {
            Err(refuse(format!("F{feed}"), "a feed must be positive"))
        }
    }
}
