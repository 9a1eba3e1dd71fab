// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The controls that programs are written for, and what they read.

use super::{NcAxis, NumberFormat};
use alloc::string::String;

/// A family of controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dialect {
    /// LinuxCNC 2.8 and later.
    LinuxCnc,
    /// Fanuc and who speaks like it, with custom macros (`G65`); on a lathe with G codes of system B or C.
    Fanuc,
    /// SINUMERIK 840D sl, 828D and ONE.
    Siemens,
}

/// A file of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramFile {
    /// Its name with its extension.
    pub name: String,
    /// Content of the file: ASCII.
    pub text: String,
}

/// Syntax rules of a control.
#[derive(Debug)]
pub(super) struct Rules {
    /// Digits of a coordinate, before and behind the point together.
    pub(super) digits: u32,
    /// Smallest and largest inverse time (1/min) and its decimal places.
    pub(super) feed: (f64, f64, usize),
    /// Numbers of programs, where they have numbers. Those above are protected or the maker's on most machines.
    pub(super) numbers: Option<(u32, u32)>,
    /// Length of a program's name.
    pub(super) name_length: usize,
    /// True if names are in capitals.
    pub(super) capital_names: bool,
    /// True if comments are in capitals and without underscores.
    pub(super) capital_text: bool,
    /// Replacement for a comma in a comment: LinuxCNC executes `(msg,…)`, `(logopen,…)` and similar.
    pub(super) comma: char,
    /// Opening and closing text of a comment.
    pub(super) comment: (&'static str, &'static str),
}

/// Most characters of a comment.
pub(super) const TEXT_LENGTH: usize = 120;
/// Largest number of a tool.
pub(super) const MAX_TOOL: u32 = 9_999;
/// Largest spindle speed (1/min).
pub(super) const MAX_RPM: u32 = 99_999;
/// Longest pause (ms).
pub(super) const MAX_DWELL_MS: u32 = 9_999_999;

static LINUXCNC: Rules = Rules {
    digits: 12,
    feed: (1e-4, 9_999_999.0, 9),
    numbers: None,
    name_length: 60,
    capital_names: false,
    capital_text: false,
    comma: ';',
    comment: ("(", ")"),
};

/// B-62764EN (Series 16/18), 5: an inverse time is within 0.001 and 9999.999, whatever the increment system. Below 0.5, a block of two
/// minutes, its three places would be a thousandth of it and more.
static FANUC: Rules = Rules {
    digits: 8,
    feed: (0.5, 9_999.999, 3),
    numbers: Some((1, 7_999)),
    name_length: 60,
    capital_names: true,
    capital_text: true,
    comma: ',',
    comment: ("(", ")"),
};

/// 6FC5398-2EP40 (SINUMERIK ONE, NC programming), 2.2.1 and 3.2.1.2, on names.
static SIEMENS: Rules = Rules {
    digits: 12,
    feed: (1e-4, 9_999_999.0, 9),
    numbers: None,
    name_length: 24,
    capital_names: true,
    capital_text: false,
    comma: ',',
    comment: ("; ", ""),
};

impl Dialect {
    pub const ALL: [Dialect; 3] = [Dialect::LinuxCnc, Dialect::Fanuc, Dialect::Siemens];

    pub(super) const fn rules(self) -> &'static Rules {
        match self {
            Dialect::LinuxCnc => &LINUXCNC,
            Dialect::Fanuc => &FANUC,
            Dialect::Siemens => &SIEMENS,
        }
    }

    /// Largest position of C in increments.
    pub(super) fn max_c_increments(self, format: NumberFormat) -> i64 {
        let digits = self.rules().digits.min(8 + format.decimals(NcAxis::C));
        10_i64.saturating_pow(digits) - 1
    }

    /// The shortest time that a block can be given (s): an inverse time has a largest value.
    #[must_use]
    pub fn shortest_block_s(self) -> f64 {
        60.0 / self.rules().feed.1
    }

    /// The longest time that a block can be given (s).
    pub(super) fn longest_block_s(self) -> f64 {
        60.0 / self.rules().feed.0
    }
}
