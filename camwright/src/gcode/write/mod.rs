// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The text of a program: one walk over what it says, in the words of a dialect.

mod section;
mod words;

use super::dialect::{Dialect, MAX_TOOL, ProgramFile, TEXT_LENGTH};
use super::fitted::{self, ProgramNames};
use super::{Block, NcAxis, Program, Step, WriteError, XValues};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use section::Section;

impl Dialect {
    /// The text of a program, the file with its main program first.
    ///
    /// # Errors
    /// The construct that this control cannot express, with its block.
    pub fn write(self, program: &Program) -> Result<Vec<ProgramFile>, WriteError> {
        files(self, program)
    }
}

/// All files, that with the main program first.
fn files(dialect: Dialect, program: &Program) -> Result<Vec<ProgramFile>, WriteError> {
    check_tools(program)?;
    let names = ProgramNames::new(dialect, program)?;
    let head = head(dialect, program)?;
    let main = main(dialect, program, &names)?;
    let mut subprograms = Vec::new();
    for index in 0..program.subprograms.len() {
        subprograms.push(subprogram(dialect, program, &names, index)?);
    }
    Ok(words::files(dialect, program, &names, &head, main, subprograms))
}

fn check_tools(program: &Program) -> Result<(), WriteError> {
    for (index, tool) in program.tools.iter().enumerate() {
        let (number, radius_mm) = (tool.number, tool.radius_mm);
        let known = (1..=MAX_TOOL).contains(&number) && radius_mm > 0.0 && radius_mm.is_finite();
        if !known {
            return Err(WriteError::BadTool { number, radius_mm, max: MAX_TOOL });
        }
        if program.tools[..index].iter().any(|other| other.number == number) {
            return Err(WriteError::SameTool { number });
        }
    }
    Ok(())
}

/// Header comments for the operator.
fn head(dialect: Dialect, program: &Program) -> Result<String, WriteError> {
    let mut head = String::new();
    let mut line = |text: &str| -> Result<(), WriteError> {
        words::push_comment(dialect, &mut head, &fitted::text(dialect, text)?);
        Ok(())
    };
    line(&program.name)?;
    for text in &program.header {
        line(text)?;
    }
    for tool in &program.tools {
        line(&format!("T{} radius {:.4} mm {}", tool.number, tool.radius_mm, tool.text))?;
    }
    line(words::about_c(dialect))?;
    line(match program.format.x_values() {
        XValues::Radius => "X is the distance from the axis of C",
        XValues::Diameter => "X is a diameter",
    })?;
    for text in words::about_machine(dialect, program.format.x_values()) {
        line(text)?;
    }
    Ok(head)
}

fn main(dialect: Dialect, program: &Program, names: &ProgramNames) -> Result<String, WriteError> {
    let mut section = Section::new(dialect, program, None);
    words::push_start(dialect, program, names, &mut section.text);
    for step in &program.main {
        section.begin_block();
        match step {
            Step::Block(block) => section.block(block)?,
            Step::Call(call) => section.call(call, names)?,
        }
    }
    section.end_feeding();
    section.text.push_str(words::end(dialect, has_tolerance(program)));
    Ok(section.text)
}

fn has_tolerance(program: &Program) -> bool {
    let main = program.main.iter().filter_map(|step| match step {
        Step::Block(block) => Some(block),
        Step::Call(_) => None,
    });
    let mut blocks = main.chain(program.subprograms.iter().flat_map(|sub| &sub.blocks));
    blocks.any(|block| matches!(block, Block::PathTolerance(_)))
}

fn subprogram(dialect: Dialect, program: &Program, names: &ProgramNames, index: usize) -> Result<String, WriteError> {
    let sub = &program.subprograms[index];
    let axis = sub.offset_axis.map(NcAxis::from);
    let mut section = Section::new(dialect, program, Some(sub));
    let title = fitted::text(dialect, &sub.title)?;
    words::push_subprogram_start(dialect, &mut section.text, sub, &names.subprograms[index], &title);
    words::push_shift(dialect, &mut section.text, axis, program.format.x_values());
    for block in &sub.blocks {
        section.begin_block();
        section.block(block)?;
    }
    section.end_feeding();
    words::push_no_shift(dialect, &mut section.text, axis, program.format);
    words::push_subprogram_end(dialect, &mut section.text, &names.subprograms[index]);
    Ok(section.text)
}

const _: () = assert!(TEXT_LENGTH < 250, "LinuxCNC reads lines of 255 characters");
