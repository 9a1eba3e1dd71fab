// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A line of a program as words.

use super::number::Fixed;
use super::{Dialect, ReadFault};
use alloc::borrow::Cow;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Arguments of the running subprogram.
#[derive(Debug, Clone, Default)]
pub(super) struct WordParameters {
    /// Names, where the dialect names them; in others they are numbered from 1.
    pub(super) names: Vec<String>,
    pub(super) values: Vec<Fixed>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Word<'a> {
    /// A letter with a number, and whether that has a point or was computed.
    Address { letter: u8, value: Fixed, point: bool },
    /// A word of several letters.
    Name(&'a str),
    /// A word of several letters with a value.
    Assigned(&'a str, Fixed),
    /// A word of several letters with values in brackets.
    Call(&'a str, Vec<Fixed>),
}

/// Words of comments that LinuxCNC executes.
const ACTIVE: [&str; 11] =
    ["debug", "print", "log", "logopen", "logappend", "logclose", "probeopen", "probeclose", "py", "pyrun", "abort"];

/// The line without its comments.
pub(super) fn without_comments(dialect: Dialect, line: &str) -> Result<Cow<'_, str>, ReadFault> {
    if dialect == Dialect::Siemens {
        return Ok(Cow::Borrowed(line.split(';').next().unwrap_or_default()));
    }
    if !line.contains(['(', ';']) {
        return Ok(Cow::Borrowed(line));
    }
    let mut kept = String::new();
    let mut rest = line;
    while let Some(at) = rest.find(['(', ';']) {
        kept.push_str(&rest[..at]);
        let comment = &rest[at + 1..];
        if rest[at..].starts_with(';') {
            if dialect == Dialect::Fanuc {
                return Err(ReadFault::NoWord { text: ";".into() });
            }
            check_passive(dialect, comment)?;
            return Ok(Cow::Owned(kept));
        }
        let end = comment.find(['(', ')']).filter(|end| comment[*end..].starts_with(')'));
        let end = end.ok_or(ReadFault::UnclosedComment)?;
        check_passive(dialect, &comment[..end])?;
        // A comment parts words.
        kept.push(' ');
        rest = &comment[end + 1..];
    }
    kept.push_str(rest);
    Ok(Cow::Owned(kept))
}

fn check_passive(dialect: Dialect, comment: &str) -> Result<(), ReadFault> {
    let word = comment.split(',').next().unwrap_or_default().trim();
    let is_active = || ACTIVE.iter().any(|active| word.eq_ignore_ascii_case(active));
    if dialect == Dialect::LinuxCnc && comment.contains(',') && is_active() {
        return Err(ReadFault::ActiveComment { word: word.to_string() });
    }
    Ok(())
}

/// Takes a line apart, word by word.
#[derive(Debug)]
pub(super) struct LineCursor<'a> {
    pub(super) rest: &'a str,
    dialect: Dialect,
}

impl<'a> LineCursor<'a> {
    pub(super) const fn new(dialect: Dialect, line: &'a str) -> Self {
        Self { rest: line, dialect }
    }

    fn skip_space(&mut self) {
        self.rest = self.rest.trim_start_matches([' ', '\t']);
    }

    /// The next character after space.
    pub(super) fn peek(&mut self) -> Option<u8> {
        self.skip_space();
        self.rest.bytes().next()
    }

    /// Skips the next character if it is this one; returns whether it was.
    pub(super) fn skip_if(&mut self, wanted: u8) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.rest = &self.rest[1..];
        }
        found
    }

    fn need(&mut self, wanted: u8) -> Result<(), ReadFault> {
        if self.skip_if(wanted) { Ok(()) } else { Err(self.no_word()) }
    }

    /// Error: the text at this position is no word.
    pub(super) fn no_word(&self) -> ReadFault {
        ReadFault::NoWord { text: self.rest.trim().chars().take(20).collect() }
    }

    /// A name of letters, digits and underscores, empty if there is none.
    pub(super) fn name(&mut self) -> &'a str {
        self.skip_space();
        let is_end = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
        let (name, rest) = self.rest.split_at(self.rest.find(is_end).unwrap_or(self.rest.len()));
        self.rest = rest;
        name
    }

    /// The next word; `None` at the end of the line.
    pub(super) fn word(&mut self, parameters: &WordParameters) -> Result<Option<Word<'a>>, ReadFault> {
        let Some(first) = self.peek() else { return Ok(None) };
        if !(first.is_ascii_alphabetic() || first == b'_' && self.dialect == Dialect::Siemens) {
            return Err(self.no_word());
        }
        let second = self.rest.as_bytes().get(1).copied().unwrap_or_default();
        let many = first == b'_' || second.is_ascii_alphabetic() || matches!(second, b'_' | b'=' | b'(');
        if self.dialect == Dialect::Siemens && many {
            return self.long_word(parameters).map(Some);
        }
        self.rest = &self.rest[1..];
        let (value, point) = self.value(parameters)?;
        Ok(Some(Word::Address { letter: first.to_ascii_uppercase(), value, point }))
    }

    /// A word of SINUMERIK: a name, perhaps with a value or with values in brackets.
    fn long_word(&mut self, parameters: &WordParameters) -> Result<Word<'a>, ReadFault> {
        let name = self.name();
        if self.skip_if(b'=') {
            let (value, _) = self.value(parameters)?;
            return Ok(match name.as_bytes() {
                [letter] if letter.is_ascii_alphabetic() => {
                    Word::Address { letter: letter.to_ascii_uppercase(), value, point: true }
                }
                _ => Word::Assigned(name, value),
            });
        }
        if !self.skip_if(b'(') {
            return Ok(Word::Name(name));
        }
        let mut values = Vec::new();
        loop {
            values.push(self.value(parameters)?.0);
            if self.skip_if(b')') {
                return Ok(Word::Call(name, values));
            }
            self.need(b',')?;
        }
    }

    /// A number, or what a parameter means.
    pub(super) fn value(&mut self, parameters: &WordParameters) -> Result<(Fixed, bool), ReadFault> {
        match self.peek() {
            Some(b'#') if self.dialect != Dialect::Siemens => {
                self.rest = &self.rest[1..];
                let digits = self.rest.bytes().take_while(u8::is_ascii_digit).count();
                let (number, rest) = self.rest.split_at(digits);
                let index = number.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
                self.rest = rest;
                let value = index.and_then(|index| parameters.values.get(index));
                let value = value.ok_or_else(|| ReadFault::NotPassed { name: ["#", number].concat() })?;
                Ok((*value, true))
            }
            Some(b'[') if self.dialect != Dialect::Siemens => {
                self.rest = &self.rest[1..];
                let (value, _, length) = Fixed::parse(self.rest.trim_start_matches(' '))?;
                self.skip_space();
                self.rest = &self.rest[length..];
                self.need(b']')?;
                Ok((value, true))
            }
            Some(byte) if self.dialect == Dialect::Siemens && (byte.is_ascii_alphabetic() || byte == b'_') => {
                let name = self.name();
                let index = parameters.names.iter().position(|known| known.eq_ignore_ascii_case(name));
                let value = index.and_then(|index| parameters.values.get(index));
                let value = value.ok_or_else(|| ReadFault::NotPassed { name: name.into() })?;
                Ok((*value, true))
            }
            _ => {
                let (value, point, length) = Fixed::parse(self.rest)?;
                self.rest = &self.rest[length..];
                Ok((value, point))
            }
        }
    }
}
