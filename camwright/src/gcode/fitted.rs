// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names and texts as a control can read them.

use super::dialect::{Dialect, TEXT_LENGTH};
use super::{Program, WriteError};
use alloc::string::String;
use alloc::vec::Vec;

/// Names of the main program and of its subprograms on a control: letters, digits and underscores, all different.
#[derive(Debug)]
pub(super) struct ProgramNames {
    pub(super) main: String,
    pub(super) subprograms: Vec<String>,
}

/// Beginnings that SINUMERIK keeps for itself (6FC5 298-7AB00, 2.2).
const SIEMENS_RESERVED: [&str; 3] = ["CYCLE", "CC", "E_"];

impl ProgramNames {
    pub(super) fn new(dialect: Dialect, program: &Program) -> Result<Self, WriteError> {
        let all = || core::iter::once(&program.name).chain(program.subprograms.iter().map(|sub| &sub.name));
        let mut fitted: Vec<String> = Vec::new();
        for name in all() {
            let new = fit_name(dialect, name).ok_or_else(|| WriteError::NoName { name: name.clone() })?;
            if let Some((first, _)) = all().zip(&fitted).find(|(_, there)| **there == new) {
                return Err(WriteError::SameName { first: first.clone(), second: name.clone(), fitted: new });
            }
            fitted.push(new);
        }
        check_numbers(dialect, program)?;
        let subprograms = fitted.split_off(1);
        Ok(Self { main: fitted.pop().unwrap_or_default(), subprograms })
    }
}

/// Fit for a control: what it cannot read becomes an underscore. On SINUMERIK a name of a user has an underscore, so that it is no word of
/// the control's language, and begins with two letters.
fn fit_name(dialect: Dialect, name: &str) -> Option<String> {
    let rules = dialect.rules();
    let mut fitted: String =
        name.trim().chars().flat_map(plain).map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !fitted.contains(|c: char| c.is_ascii_alphanumeric()) {
        return None;
    }
    fitted = if rules.capital_names { fitted.to_ascii_uppercase() } else { fitted.to_ascii_lowercase() };
    let letters = fitted.bytes().take_while(u8::is_ascii_alphabetic).count();
    let reserved = SIEMENS_RESERVED.iter().any(|word| fitted.starts_with(word));
    if dialect == Dialect::Siemens && (letters < 2 || reserved || !fitted.contains('_')) {
        fitted.insert_str(0, "NC_");
    }
    fitted.truncate(rules.name_length);
    Some(fitted)
}

fn check_numbers(dialect: Dialect, program: &Program) -> Result<(), WriteError> {
    let Some((min, max)) = dialect.rules().numbers else { return Ok(()) };
    let mut seen: Vec<(u32, &String)> = Vec::new();
    let all = core::iter::once((program.number, &program.name))
        .chain(program.subprograms.iter().map(|sub| (sub.number, &sub.name)));
    for (number, name) in all {
        if !(min..=max).contains(&number) {
            return Err(WriteError::ProgramNumber { name: name.clone(), number, min, max });
        }
        if let Some((_, first)) = seen.iter().find(|(there, _)| *there == number) {
            return Err(WriteError::SameNumber { first: (*first).clone(), second: name.clone(), number });
        }
        seen.push((number, name));
    }
    Ok(())
}

/// A character in ASCII: letters that have a usual spelling there, everything else that has none as a hyphen.
fn plain(c: char) -> impl Iterator<Item = char> {
    let text: &[char] = match c {
        'ä' => &['a', 'e'],
        'ö' => &['o', 'e'],
        'ü' => &['u', 'e'],
        'Ä' => &['A', 'e'],
        'Ö' => &['O', 'e'],
        'Ü' => &['U', 'e'],
        'ß' => &['s', 's'],
        'µ' | 'μ' => &['u'],
        '°' => &['d', 'e', 'g'],
        '×' => &['x'],
        ' '..='~' => &[],
        _ => &['-'],
    };
    text.iter().copied().chain(text.is_empty().then_some(c))
}

/// A text as a comment of a control may have it: ASCII without what would end it, or make it more than a comment.
pub(super) fn text(dialect: Dialect, text: &str) -> Result<String, WriteError> {
    let rules = dialect.rules();
    let harmless = |c: char| match c {
        ',' => rules.comma,
        c if c.is_ascii_alphanumeric() || " .,+-*/=#_".contains(c) => c,
        _ => '-',
    };
    let mut fitted: String = text.trim().chars().flat_map(plain).map(harmless).collect();
    if rules.capital_text {
        fitted = fitted.to_ascii_uppercase().replace('_', "-");
    }
    if fitted.len() > TEXT_LENGTH {
        let text = fitted.chars().take(40).collect();
        return Err(WriteError::LongText { characters: fitted.len(), max: TEXT_LENGTH, text });
    }
    Ok(fitted)
}
