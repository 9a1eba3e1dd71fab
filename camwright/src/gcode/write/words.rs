// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Words in which the dialects differ.

use crate::gcode::dialect::{Dialect, ProgramFile};
use crate::gcode::fitted::ProgramNames;
use crate::gcode::{Call, NcAxis, NumberFormat, Program, Subprogram, XValues};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// A count of increments as a decimal number, with all its places.
pub(super) fn decimal(count: i64, decimals: u32) -> String {
    let unit = 10_u64.saturating_pow(decimals);
    let (sign, size) = (if count < 0 { "-" } else { "" }, count.unsigned_abs());
    format!("{sign}{}.{:0places$}", size / unit, size % unit, places = decimals as usize)
}

pub(super) fn push_comment(dialect: Dialect, to: &mut String, text: &str) {
    let (open, close) = dialect.rules().comment;
    to.push_str(&format!("{open}{text}{close}\n"));
}

/// C is counted on; a control that takes it for a place on a turn would turn back, or the other way round.
pub(super) const fn about_c(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::LinuxCnc => "C counts on over whole turns. WRAPPED_ROTARY = 0",
        Dialect::Fanuc => "C counts on over whole turns. No roll-over, parameter 1008 bit 0 = 0",
        Dialect::Siemens => "C counts on over whole turns. No modulo axis, ROT_IS_MODULO = 0 in MD30310",
    }
}

/// Further machine settings that the program requires.
pub(super) fn about_machine(dialect: Dialect, x_values: XValues) -> Vec<&'static str> {
    match (dialect, x_values) {
        (Dialect::Fanuc, x_values) => {
            let x = match x_values {
                XValues::Radius => "Parameter 1006 bit 3 = 0 for X",
                XValues::Diameter => "Parameter 1006 bit 3 = 1 for X",
            };
            Vec::from([x, "On a lathe G code system B or C"])
        }
        _ => Vec::new(),
    }
}

/// A safe state to begin in: metric, absolute, no compensation, no cycle, no earlier shift.
pub(super) fn push_start(dialect: Dialect, program: &Program, names: &ProgramNames, to: &mut String) {
    let x_values = program.format.x_values();
    match dialect {
        Dialect::LinuxCnc => {
            let x = if x_values == XValues::Diameter { "G7" } else { "G8" };
            to.push_str(&format!("G21 G17 G90 G94\nG40 G49 G80\nG54 {x}\nG92.1\n"));
        }
        Dialect::Fanuc => to.push_str("G21 G17 G90 G94\nG40 G49 G80\nG54\n"),
        Dialect::Siemens => {
            for (name, sub) in names.subprograms.iter().zip(&program.subprograms) {
                let parameters = if sub.offset_axis.is_some() { "REAL, REAL" } else { "REAL" };
                to.push_str(&format!("EXTERN {name}({parameters})\n"));
            }
            let x = if x_values == XValues::Diameter { "DIAMON" } else { "DIAMOF" };
            to.push_str(&format!("G71 G17 G90 G94\nG40 G54\nMCALL\nTRANS\n{x}\n"));
        }
    }
}

/// The end, with contour control off again on a Fanuc, where it would outlive the program.
pub(super) const fn end(dialect: Dialect, has_tolerance: bool) -> &'static str {
    match dialect {
        Dialect::LinuxCnc => "M2\n",
        Dialect::Fanuc if has_tolerance => "G5.1 Q0\nM30\n",
        Dialect::Fanuc | Dialect::Siemens => "M30\n",
    }
}

/// The tool with its length: targets are places of the tool.
pub(super) fn tool_change(dialect: Dialect, number: u32) -> String {
    match dialect {
        Dialect::LinuxCnc => format!("T{number} M6\nG43\n"),
        Dialect::Fanuc => format!("T{number} M6\nG43 H{number}\n"),
        Dialect::Siemens => format!("T{number}\nM6\nD1\n"),
    }
}

/// Fanuc's contour control takes its tolerance from parameters of the machine.
pub(super) fn path_tolerance(dialect: Dialect, mm: &str) -> String {
    match dialect {
        // Without Q the tolerance would also be that within which blocks are replaced by one.
        Dialect::LinuxCnc => format!("G64 P{mm} Q0\n"),
        Dialect::Fanuc => format!("G5.1 Q1\n(PATH TOLERANCE {mm} MM BY PARAMETER)\n"),
        Dialect::Siemens => format!("G642 CTOL={mm}\n"),
    }
}

pub(super) fn dwell(dialect: Dialect, seconds: &str) -> String {
    match dialect {
        Dialect::LinuxCnc => format!("G4 P{seconds}\n"),
        Dialect::Fanuc => format!("G4 X{seconds}\n"),
        Dialect::Siemens => format!("G4 F{seconds}\n"),
    }
}

pub(super) fn push_subprogram_start(dialect: Dialect, to: &mut String, sub: &Subprogram, name: &str, title: &str) {
    match dialect {
        Dialect::LinuxCnc => to.push_str(&format!("o<{name}> sub\n")),
        Dialect::Fanuc => {
            to.push_str(&format!("O{:04} ({})\n", sub.number, name.replace('_', "-")));
        }
        Dialect::Siemens => {
            let offset = if sub.offset_axis.is_some() { ", REAL OFFSET_MM" } else { "" };
            to.push_str(&format!("PROC {name}(REAL PHASE_DEG{offset})\n"));
        }
    }
    push_comment(dialect, to, title);
}

pub(super) fn push_subprogram_end(dialect: Dialect, to: &mut String, name: &str) {
    match dialect {
        Dialect::LinuxCnc => to.push_str(&format!("o<{name}> endsub\n")),
        Dialect::Fanuc => to.push_str("M99\n"),
        Dialect::Siemens => to.push_str("M17\n"),
    }
}

/// Returns whether a shift is in radii although coordinates are diameters. SINUMERIK shifts by a `TRANS` between `DIAMOF` and `DIAMON`,
/// which works on all its versions.
fn shifts_radius(dialect: Dialect, axis: Option<NcAxis>, x_values: XValues) -> bool {
    dialect == Dialect::Siemens && axis == Some(NcAxis::X) && x_values == XValues::Diameter
}

/// The coordinate system goes to where the call says.
pub(super) fn push_shift(dialect: Dialect, to: &mut String, axis: Option<NcAxis>, x_values: XValues) {
    let letter = axis.map(NcAxis::letter);
    match dialect {
        Dialect::LinuxCnc | Dialect::Fanuc => {
            let linear = letter.map_or_else(String::new, |letter| format!(" {letter}#2"));
            to.push_str(&format!("G52{linear} C#1\n"));
        }
        Dialect::Siemens => {
            let linear = letter.map_or_else(String::new, |letter| format!(" {letter}=OFFSET_MM"));
            let radius = shifts_radius(dialect, axis, x_values);
            to.push_str(if radius { "DIAMOF\n" } else { "" });
            to.push_str(&format!("TRANS{linear} C=PHASE_DEG\n"));
            to.push_str(if radius { "DIAMON\n" } else { "" });
        }
    }
}

pub(super) fn push_no_shift(dialect: Dialect, to: &mut String, axis: Option<NcAxis>, format: NumberFormat) {
    match dialect {
        Dialect::LinuxCnc | Dialect::Fanuc => {
            let zero = |axis: NcAxis| format!(" {}{}", axis.letter(), decimal(0, format.decimals(axis)));
            to.push_str(&format!("G52{}{}\n", axis.map_or_else(String::new, zero), zero(NcAxis::C)));
        }
        Dialect::Siemens => to.push_str("TRANS\n"),
    }
}

pub(super) fn push_call(
    dialect: Dialect,
    to: &mut String,
    format: NumberFormat,
    names: &ProgramNames,
    call: &Call,
    sub: &Subprogram,
) {
    let name = &names.subprograms[call.subprogram];
    let phase = decimal(call.phase, format.decimals(NcAxis::C));
    let axis = sub.offset_axis.map(NcAxis::from);
    let decimals = axis.map_or(1, |axis| format.decimals(axis));
    // Half of a diameter has one place more.
    let offset = if shifts_radius(dialect, axis, format.x_values()) {
        decimal(call.offset.saturating_mul(5), decimals + 1)
    } else {
        decimal(call.offset, decimals)
    };
    let (phase, offset) = match dialect {
        Dialect::LinuxCnc => (format!("o<{name}> call [{phase}]"), format!(" [{offset}]")),
        Dialect::Fanuc => (format!("G65 P{} A{phase}", sub.number), format!(" B{offset}")),
        Dialect::Siemens => (format!("{name}({phase}"), format!(", {offset}")),
    };
    let close = if dialect == Dialect::Siemens { ")" } else { "" };
    to.push_str(&format!("{phase}{}{close}\n", if axis.is_some() { &offset } else { "" }));
}

/// Puts together what belongs into one file.
pub(super) fn files(
    dialect: Dialect,
    program: &Program,
    names: &ProgramNames,
    head: &str,
    main: String,
    subprograms: Vec<String>,
) -> Vec<ProgramFile> {
    match dialect {
        // A call finds its subprogram only above it, or in a file of its own.
        Dialect::LinuxCnc => {
            let text = [head, &subprograms.concat(), &main].concat();
            Vec::from([ProgramFile { name: format!("{}.ngc", names.main), text }])
        }
        Dialect::Fanuc => {
            let title = format!("O{:04} ({})\n", program.number, names.main.replace('_', "-"));
            let text = ["%\n", &title, head, &main, &subprograms.concat(), "%\n"].concat();
            Vec::from([ProgramFile { name: format!("O{:04}.NC", program.number), text }])
        }
        Dialect::Siemens => {
            let main = ProgramFile { name: format!("{}.MPF", names.main), text: [head, &main].concat() };
            let subs = names.subprograms.iter().zip(subprograms);
            let subs = subs.map(|(name, text)| ProgramFile { name: format!("{name}.SPF"), text });
            core::iter::once(main).chain(subs).collect()
        }
    }
}
