// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The words of one block, sorted into what excludes each other.

use super::number::Fixed;
use super::words::{LineCursor, Word, WordParameters};
use super::{Dialect, ReadFault};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Modal groups: a block has at most one word of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// G0, G1, and G80 that ends them.
    Motion,
    Plane,
    Distance,
    FeedMode,
    Units,
    CutterRadius,
    ToolLength,
    Zero,
    XValues,
    Path,
    /// Codes that act once, with words of their own.
    Once,
    /// M3, M4, M5.
    Spindle,
    ToolChange,
    Coolant,
    End,
}

const GROUPS: usize = Group::End as usize + 1;

/// A block, taken apart. Words are taken out of it as they are understood, so that what is left was not.
#[derive(Debug, Default)]
pub(super) struct ReadBlock {
    groups: [Option<u32>; GROUPS],
    letters: [Option<(Fixed, bool)>; 26],
    /// A word of several letters, of which there is at most one, with its values.
    pub(super) name: Option<(String, Vec<Fixed>)>,
    /// A tolerance behind a motion's smoothing.
    pub(super) tolerance: Option<Fixed>,
}

/// Ten times the number of a G word: some have a place behind the point.
pub(super) type Code = u32;

impl ReadBlock {
    pub(super) fn new(
        dialect: Dialect,
        cursor: &mut LineCursor<'_>,
        parameters: &WordParameters,
    ) -> Result<Self, ReadFault> {
        let mut block = Self::default();
        let mut first = true;
        while let Some(word) = cursor.word(parameters)? {
            match word {
                Word::Address { letter: b'N', value, .. } if first && value.whole().is_some() => {}
                Word::Address { letter: b'G', value, .. } => block.code(dialect, value)?,
                Word::Address { letter: b'M', value, .. } => block.order(dialect, value)?,
                Word::Address { letter, value, point } => block.letter(letter, value, point)?,
                Word::Assigned(name, value) if name.eq_ignore_ascii_case("CTOL") => {
                    if block.tolerance.replace(value).is_some() {
                        return Err(ReadFault::Twice { word: "CTOL".into() });
                    }
                }
                Word::Assigned(name, _) => return Err(ReadFault::UnknownWord { word: name.to_string() }),
                Word::Name(name) => block.name(name, Vec::new())?,
                Word::Call(name, values) => block.name(name, values)?,
            }
            first = false;
        }
        Ok(block)
    }

    fn letter(&mut self, letter: u8, value: Fixed, point: bool) -> Result<(), ReadFault> {
        let word = || char::from(letter).to_string();
        let slot = self.letters.get_mut(usize::from(letter.wrapping_sub(b'A')));
        match slot.map(|slot| slot.replace((value, point))) {
            Some(None) => Ok(()),
            Some(Some(_)) => Err(ReadFault::Twice { word: word() }),
            None => Err(ReadFault::UnknownWord { word: word() }),
        }
    }

    fn name(&mut self, name: &str, values: Vec<Fixed>) -> Result<(), ReadFault> {
        let second = name.to_ascii_uppercase();
        match self.name.replace((second.clone(), values)) {
            Some((first, _)) => Err(ReadFault::OneGroup { first, second }),
            None => Ok(()),
        }
    }

    fn set_code(&mut self, group: Group, code: u32, letter: char) -> Result<(), ReadFault> {
        let name = |code: u32| word(letter, code);
        match self.groups[group as usize].replace(code) {
            Some(before) if before == code => Err(ReadFault::Twice { word: name(code) }),
            Some(before) => Err(ReadFault::OneGroup { first: name(before), second: name(code) }),
            None => Ok(()),
        }
    }

    fn code(&mut self, dialect: Dialect, value: Fixed) -> Result<(), ReadFault> {
        let unknown = || ReadFault::UnknownWord { word: format!("G{value}") };
        let code = value.tenths().ok_or_else(unknown)?;
        let group = match (code, dialect) {
            (0 | 10 | 800, _) => Group::Motion,
            (170 | 180 | 190, _) => Group::Plane,
            (900, _) => Group::Distance,
            (930 | 940, _) => Group::FeedMode,
            (210, Dialect::LinuxCnc | Dialect::Fanuc) | (710 | 7100, Dialect::Siemens) => Group::Units,
            (400, _) => Group::CutterRadius,
            (430 | 490, Dialect::LinuxCnc | Dialect::Fanuc) => Group::ToolLength,
            (540, _) => Group::Zero,
            (70 | 80, Dialect::LinuxCnc) => Group::XValues,
            (640, Dialect::LinuxCnc | Dialect::Siemens) | (6420, Dialect::Siemens) => Group::Path,
            (40, _) | (520, Dialect::LinuxCnc | Dialect::Fanuc) | (921, Dialect::LinuxCnc) => Group::Once,
            (51 | 650, Dialect::Fanuc) => Group::Once,
            _ => return Err(refused(dialect, code).unwrap_or_else(unknown)),
        };
        self.set_code(group, code, 'G')
    }

    fn order(&mut self, dialect: Dialect, value: Fixed) -> Result<(), ReadFault> {
        let unknown = || ReadFault::UnknownWord { word: format!("M{value}") };
        let code = value.whole().ok_or_else(unknown)?;
        let group = match (code, dialect) {
            (3..=5, _) => Group::Spindle,
            (6, _) => Group::ToolChange,
            (8 | 9, _) => Group::Coolant,
            (2 | 30, _) | (17, Dialect::Siemens) | (98 | 99, Dialect::Fanuc) => Group::End,
            _ => return Err(unknown()),
        };
        // In tenths, as those of G, so that one function names them.
        self.set_code(group, code * 10, 'M')
    }

    /// Takes the word of a group: ten times its number.
    pub(super) fn take_code(&mut self, group: Group) -> Option<Code> {
        self.groups[group as usize].take()
    }

    pub(super) const fn has(&self, group: Group) -> bool {
        self.groups[group as usize].is_some()
    }

    /// Takes the value of a letter.
    pub(super) fn value(&mut self, letter: u8) -> Option<Fixed> {
        self.letters[usize::from(letter - b'A')].take().map(|(value, _)| value)
    }

    /// The same, where a number without a point would mean another one.
    pub(super) fn pointed(&mut self, dialect: Dialect, letter: u8) -> Result<Option<Fixed>, ReadFault> {
        match self.letters[usize::from(letter - b'A')].take() {
            Some((value, false)) if dialect == Dialect::Fanuc && value != Fixed::ZERO => {
                Err(ReadFault::NoPoint { word: format!("{}{value}", char::from(letter)) })
            }
            found => Ok(found.map(|(value, _)| value)),
        }
    }

    /// The same, for a whole number.
    pub(super) fn whole(&mut self, letter: u8, min: u32, max: u32) -> Result<Option<u32>, ReadFault> {
        let Some(value) = self.value(letter) else { return Ok(None) };
        let whole = value.whole().filter(|whole| (min..=max).contains(whole));
        let word = || format!("{}{value}", char::from(letter));
        whole.map(Some).ok_or_else(|| ReadFault::NotWhole { word: word(), min, max })
    }

    /// The first unused word.
    pub(super) fn left(&self) -> Option<String> {
        let letters = (b'A'..=b'Z').zip(self.letters).find_map(|(letter, value)| Some((letter, value?.0)));
        let letter = letters.map(|(letter, value)| format!("{}{value}", char::from(letter)));
        let code = self.groups.iter().flatten().next().map(|code| word('G', *code));
        let name = self.name.as_ref().map(|(name, _)| name.clone());
        letter.or(name).or(code).or(self.tolerance.map(|value| format!("CTOL={value}")))
    }
}

/// A word as it is written, of ten times its number.
pub(super) fn word(letter: char, code: Code) -> String {
    if code.is_multiple_of(10) {
        format!("{letter}{}", code / 10)
    } else {
        format!("{letter}{}.{}", code / 10, code % 10)
    }
}

/// Codes that are understood and not read, and why.
fn refused(dialect: Dialect, code: Code) -> Option<ReadFault> {
    let is_siemens = dialect == Dialect::Siemens;
    let why = match code {
        20 | 30 => "arcs are not read; C and X make curves of straight blocks",
        200 if !is_siemens => "inches are not read; the program must be metric",
        700 | 7000 if is_siemens => "inches are not read; the program must be metric",
        910 => "incremental targets are not read: an error of one block would be in all that follow",
        950 => "a feed per turn of the cutter says no time; G93 is needed",
        410 | 420 => "compensation of the radius is not read; targets are places of the cutter's centre",
        550 | 560 | 570 | 580 | 590 => "another zero point than that of G54 is not read",
        _ => return None,
    };
    Some(ReadFault::Refused { word: word('G', code), why })
}
