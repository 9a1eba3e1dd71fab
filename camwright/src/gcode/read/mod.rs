// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs read back: a tokeniser and a modal interpreter of the dialects, which share nothing with what writes them.
//!
//! What is not understood is a fault and never skipped: a control might well understand it.

mod block;
mod error;
mod library;
mod number;
mod state;
mod words;

pub use error::{ReadError, ReadFault};

use super::{Dialect, Done, ProgramFile, ProgramMotion, SubprogramCall, XValues};
use alloc::string::ToString;
use alloc::vec;
use alloc::vec::Vec;
use block::ReadBlock;
use library::{OWord, SourcePosition, SubprogramLibrary, error as error_at, line_at};
use number::Fixed;
use state::{Flow, ModalState};
use words::{LineCursor, WordParameters};

/// Most text that is read (bytes).
pub const MAX_TEXT_BYTES: usize = 512 << 20;
/// Most blocks that are executed.
pub const MAX_BLOCKS: u32 = 12_000_000;
/// Longest line (bytes).
pub const LONGEST_LINE: usize = 512;
/// Most calls within calls.
pub const MAX_DEPTH: usize = 8;
/// Most parameters of a call.
const MAX_PARAMETERS: usize = 8;

/// Reads a program: the file with the main program first. `x_values` is what X means where the program does not say it.
///
/// # Errors
/// The first thing that is not understood, or must not be, with its file and line.
pub fn read(dialect: Dialect, x_values: XValues, files: &[ProgramFile]) -> Result<ProgramMotion, ReadError> {
    let begin = SourcePosition { file: 0, at: 0, line: 1 };
    let bytes = files.iter().fold(0, |sum: usize, file| sum.saturating_add(file.text.len()));
    if bytes > MAX_TEXT_BYTES {
        return Err(error_at(files, begin, ReadFault::TooMuchText { bytes }));
    }
    let library = SubprogramLibrary::new(dialect, files)?;
    let Some(main) = library.programs.first() else { return Err(error_at(files, begin, ReadFault::NoProgram)) };
    let subprograms = library.programs[1..].iter().map(|program| program.name.clone()).collect();
    let mut run = ProgramReader {
        dialect,
        library: &library,
        state: ModalState::new(dialect, x_values),
        motion: ProgramMotion { subprograms, ..ProgramMotion::default() },
        stack: vec![CallFrame { program: 0, place: main.start, parameters: WordParameters::default(), call: None }],
        called: vec![false; library.programs.len()],
        blocks: 0,
        here: main.start,
    };
    match run.execute() {
        Ok(()) => Ok(run.motion),
        Err(fault) => Err(error_at(files, run.here, fault)),
    }
}

/// A program that is running.
#[derive(Debug)]
struct CallFrame {
    program: usize,
    place: SourcePosition,
    parameters: WordParameters,
    call: Option<u32>,
}

struct ProgramReader<'a> {
    dialect: Dialect,
    library: &'a SubprogramLibrary<'a>,
    state: ModalState,
    motion: ProgramMotion,
    stack: Vec<CallFrame>,
    called: Vec<bool>,
    blocks: u32,
    /// The line that is being executed.
    here: SourcePosition,
}

impl<'a> ProgramReader<'a> {
    fn execute(&mut self) -> Result<(), ReadFault> {
        while let Some(flow) = self.next_line()? {
            match flow {
                Flow::Next => {}
                Flow::Call(name, values) => self.call(&name, values)?,
                Flow::Return => {
                    if self.stack.len() < 2 {
                        let why = "M99 in a main program that was not called; a control would restart it or stop";
                        return Err(ReadFault::Refused { word: "a return".into(), why });
                    }
                    self.nothing_follows()?;
                    self.stack.pop();
                }
                Flow::End => {
                    if self.stack.len() > 1 {
                        let why = "the program would end within a subprogram";
                        return Err(ReadFault::Refused { word: "the end".into(), why });
                    }
                    self.nothing_follows()?;
                    return self.all_called();
                }
            }
        }
        Ok(())
    }

    /// Checks that every subprogram was called: an uncalled one was never read.
    fn all_called(&mut self) -> Result<(), ReadFault> {
        let mut programs = self.library.programs.iter().zip(&self.called).skip(1);
        let Some((program, _)) = programs.find(|(_, called)| !**called) else { return Ok(()) };
        self.here = program.start;
        Err(ReadFault::NeverCalled { name: program.name.clone() })
    }

    /// The next line of the running program and where it stands, behind which it goes on; `None` at its end.
    fn take_line(&mut self) -> Result<Option<&'a str>, ReadFault> {
        let library = self.library;
        let Some(frame) = self.stack.last_mut() else { return Ok(None) };
        let end = library.programs[frame.program].end;
        self.here = frame.place;
        if frame.place.at >= end {
            return Ok(None);
        }
        let Some(read) = line_at(library.files, frame.place) else { return Ok(None) };
        let (line, next) = read?;
        frame.place = next;
        self.blocks += 1;
        if self.blocks > MAX_BLOCKS {
            return Err(ReadFault::TooManyBlocks);
        }
        Ok(Some(line))
    }

    fn next_line(&mut self) -> Result<Option<Flow>, ReadFault> {
        match self.take_line()? {
            Some(line) => self.line(line).map(Some),
            None if self.dialect == Dialect::LinuxCnc && self.stack.len() > 1 => {
                self.stack.pop();
                Ok(Some(Flow::Next))
            }
            None => {
                let end = match self.dialect {
                    _ if self.stack.len() < 2 => "M2 or M30",
                    Dialect::Siemens => "M17 or RET",
                    _ => "M99",
                };
                Err(ReadFault::NoEnd { end })
            }
        }
    }

    fn line(&mut self, line: &'a str) -> Result<Flow, ReadFault> {
        let text = words::without_comments(self.dialect, line)?;
        let mut cursor = LineCursor::new(self.dialect, &text);
        let Some(first) = cursor.peek() else { return Ok(Flow::Next) };
        if first == b'/' {
            let why = "a switch at the machine decides if it is executed";
            return Err(ReadFault::Refused { word: "/".into(), why });
        }
        let library = self.library;
        let Some(frame) = self.stack.last_mut() else { return Ok(Flow::End) };
        if library::has_o_word(self.dialect, &text) {
            return o_line(library, frame, &mut cursor);
        }
        if self.dialect == Dialect::Siemens && library::declares(library, &mut cursor)? {
            return Ok(Flow::Next);
        }
        let mut block = ReadBlock::new(self.dialect, &mut cursor, &frame.parameters)?;
        #[allow(clippy::cast_possible_truncation, reason = "no more files than lines, which are counted in 32 bits")]
        let (file, line, call) = (self.here.file as u32, self.here.line, frame.call);
        let done = &mut self.motion.done;
        self.state.execute(&mut block, &mut |action| done.push(Done { file, line, call, action }))
    }

    fn call(&mut self, name: &str, values: Vec<Fixed>) -> Result<(), ReadFault> {
        let index = self.library.find(name)?;
        let name = || name.to_string();
        if self.stack.iter().any(|frame| frame.program == index) {
            return Err(ReadFault::Recursion { name: name() });
        }
        if self.stack.len() > MAX_DEPTH {
            return Err(ReadFault::TooDeep { name: name() });
        }
        let program = &self.library.programs[index];
        let passed = values.len();
        let (fits, declared) = match self.dialect {
            Dialect::Siemens => (passed == program.parameters.len(), program.parameters.len()),
            _ => (passed <= MAX_PARAMETERS, MAX_PARAMETERS),
        };
        if !fits {
            return Err(ReadFault::Parameters { name: name(), passed, declared });
        }
        let by = self.stack.last().and_then(|frame| frame.call);
        #[allow(
            clippy::cast_possible_truncation,
            reason = "no more than blocks and lines, which are counted in 32 bits"
        )]
        let (call, subprogram, file) = (self.motion.calls.len() as u32, index as u32 - 1, self.here.file as u32);
        self.motion.calls.push(SubprogramCall { subprogram, file, line: self.here.line, by });
        self.called[index] = true;
        let parameters = WordParameters { names: program.parameters.clone(), values };
        self.stack.push(CallFrame { program: index, place: program.start, parameters, call: Some(call) });
        Ok(())
    }

    /// Behind the end of a program there are comments and subprograms at most.
    fn nothing_follows(&mut self) -> Result<(), ReadFault> {
        while let Some(line) = self.take_line()? {
            let text = words::without_comments(self.dialect, line)?;
            let mut cursor = LineCursor::new(self.dialect, &text);
            if cursor.peek().is_none() {
                continue;
            }
            let library = self.library;
            let frame = self.stack.last_mut().filter(|_| library::has_o_word(self.dialect, &text));
            let skipped = frame.map(|frame| o_line(library, frame, &mut cursor));
            if !matches!(skipped, Some(Ok(Flow::Next))) {
                return Err(ReadFault::AfterEnd);
            }
        }
        Ok(())
    }
}

/// A line with an O word: a subprogram is passed over where it stands, and called where it is called.
fn o_line(
    library: &SubprogramLibrary<'_>,
    frame: &mut CallFrame,
    cursor: &mut LineCursor<'_>,
) -> Result<Flow, ReadFault> {
    let (name, keyword) = library::o_word(cursor)?;
    match keyword {
        OWord::Sub => {
            frame.place = library.programs[library.find(&name)?].after;
            Ok(Flow::Next)
        }
        OWord::EndSub => Err(ReadFault::UnknownWord { word: ["o<", &name, "> endsub"].concat() }),
        OWord::Call => {
            let mut values = Vec::new();
            while cursor.peek().is_some() {
                if cursor.peek() != Some(b'[') || values.len() >= MAX_PARAMETERS {
                    return Err(cursor.no_word());
                }
                values.push(cursor.value(&frame.parameters)?.0);
            }
            Ok(Flow::Call(name, values))
        }
    }
}
