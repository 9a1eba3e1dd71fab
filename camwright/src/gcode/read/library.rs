// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Index of the programs in the files, built before anything is executed.

use super::words::LineCursor;
use super::{Dialect, LONGEST_LINE, ProgramFile, ReadError, ReadFault, words};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A place in the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SourcePosition {
    pub(super) file: usize,
    /// Start of the line.
    pub(super) at: usize,
    /// The line, from 1.
    pub(super) line: u32,
}

/// A program: its lines from a place to the place behind the last.
#[derive(Debug, Clone)]
pub(super) struct Stored {
    pub(super) name: String,
    pub(super) start: SourcePosition,
    /// Start of the line that ends it.
    pub(super) end: usize,
    pub(super) after: SourcePosition,
    /// Names of its parameters, where the dialect declares them.
    pub(super) parameters: Vec<String>,
}

/// All programs: the main program first.
#[derive(Debug)]
pub(super) struct SubprogramLibrary<'a> {
    pub(super) files: &'a [ProgramFile],
    pub(super) programs: Vec<Stored>,
    names: BTreeMap<String, usize>,
}

/// Content of a LinuxCNC line with an O word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum OWord {
    Sub,
    EndSub,
    Call,
}

/// The line at a place, without its end, and the place behind it; `None` behind the last.
pub(super) fn line_at(
    files: &[ProgramFile],
    place: SourcePosition,
) -> Option<Result<(&str, SourcePosition), ReadFault>> {
    let rest = files.get(place.file)?.text.get(place.at..).filter(|rest| !rest.is_empty())?;
    let end = rest.find('\n');
    let line = &rest[..end.unwrap_or(rest.len())];
    if line.len() > LONGEST_LINE {
        return Some(Err(ReadFault::LongLine { bytes: line.len() }));
    }
    let at = place.at + end.map_or(rest.len(), |end| end + 1);
    let next = SourcePosition { file: place.file, at, line: place.line.saturating_add(1) };
    Some(Ok((line.strip_suffix('\r').unwrap_or(line), next)))
}

/// The name in angle brackets behind an O, and what is said of it.
pub(super) fn o_word<'a>(cursor: &mut LineCursor<'a>) -> Result<(String, OWord), ReadFault> {
    let fault = cursor.no_word();
    let is_o = cursor.skip_if(b'O') || cursor.skip_if(b'o');
    if !is_o || !cursor.skip_if(b'<') {
        return Err(fault);
    }
    let name: &'a str = cursor.name();
    if name.is_empty() || !cursor.skip_if(b'>') {
        return Err(fault);
    }
    let keyword = match cursor.name().to_ascii_lowercase().as_str() {
        "sub" => OWord::Sub,
        "endsub" => OWord::EndSub,
        "call" => OWord::Call,
        _ => return Err(fault),
    };
    Ok((name.to_ascii_lowercase(), keyword))
}

/// Returns whether a line begins with an O word.
pub(super) fn has_o_word(dialect: Dialect, line: &str) -> bool {
    dialect != Dialect::Siemens && line.trim_start().starts_with(['O', 'o'])
}

/// Finds the programs of a file.
struct Finder<'a> {
    dialect: Dialect,
    file: usize,
    file_name: &'a str,
    found: &'a mut Vec<Stored>,
    /// True while the last program is open.
    open: bool,
    /// True if the file is enclosed by `%` lines.
    codec: bool,
    /// True if the file has content.
    begun: bool,
    /// True after the second `%`.
    over: bool,
}

impl<'a> SubprogramLibrary<'a> {
    pub(super) fn new(dialect: Dialect, files: &'a [ProgramFile]) -> Result<Self, ReadError> {
        let mut programs = Vec::new();
        for (file, ProgramFile { name: file_name, .. }) in files.iter().enumerate() {
            let mut place = SourcePosition { file, at: 0, line: 1 };
            let found = &mut programs;
            let mut finder =
                Finder { dialect, file, file_name, found, open: false, codec: false, begun: false, over: false };
            finder.begin(place);
            while let Some(read) = line_at(files, place) {
                let here = place;
                let looked = read.and_then(|(line, next)| {
                    place = next;
                    finder.line(line, here, next)
                });
                looked.map_err(|fault| error(files, here, fault))?;
            }
            finder.finish(place).map_err(|fault| error(files, place, fault))?;
        }
        let mut names = BTreeMap::new();
        for (index, program) in programs.iter().enumerate() {
            if names.insert(program.name.clone(), index).is_some() {
                return Err(error(files, program.start, ReadFault::SameProgram { name: program.name.clone() }));
            }
        }
        Ok(Self { files, programs, names })
    }

    /// The place of a subprogram by its name as it is stored.
    pub(super) fn find(&self, name: &str) -> Result<usize, ReadFault> {
        let found = self.names.get(name).filter(|index| **index > 0);
        found.copied().ok_or_else(|| ReadFault::NoSubprogram { name: name.to_string() })
    }
}

pub(super) fn error(files: &[ProgramFile], place: SourcePosition, fault: ReadFault) -> ReadError {
    let file = files.get(place.file).map(|file| file.name.clone()).unwrap_or_default();
    ReadError { file, line: place.line, fault }
}

impl Finder<'_> {
    /// Opens the program that begins with the file itself.
    fn begin(&mut self, place: SourcePosition) {
        let name = match (self.dialect, self.file) {
            (Dialect::Fanuc, _) => return,
            (_, 0) => String::new(),
            // A subprogram of SINUMERIK gets its name with `PROC`; a file of LinuxCNC may hold subprograms alone.
            _ => return,
        };
        self.store(name, place, Vec::new());
    }

    fn store(&mut self, name: String, start: SourcePosition, parameters: Vec<String>) {
        self.found.push(Stored { name, start, end: usize::MAX, after: start, parameters });
    }

    fn line(&mut self, line: &str, here: SourcePosition, next: SourcePosition) -> Result<(), ReadFault> {
        if self.dialect != Dialect::Siemens && line.trim() == "%" {
            return self.percent(here, next);
        }
        // A cheap look first: most lines are blocks.
        let first = line.trim_start().bytes().next();
        if self.over {
            return if first.is_none() { Ok(()) } else { Err(ReadFault::AfterEnd) };
        }
        let Some(first) = first else { return Ok(()) };
        self.begun = true;
        match (self.dialect, first) {
            (Dialect::LinuxCnc, b'O' | b'o') => self.o_line(line, here, next),
            (Dialect::Fanuc, b'O' | b'o') => self.number_line(line, here, next),
            (Dialect::Fanuc, _) if !self.open => self.only_comment(line),
            (Dialect::Siemens, _) if self.file > 0 && !self.open => self.proc_line(line, next),
            (Dialect::LinuxCnc, _) if self.file > 0 && !self.open => self.only_comment(line),
            _ => Ok(()),
        }
    }

    fn only_comment(&self, line: &str) -> Result<(), ReadFault> {
        let text = words::without_comments(self.dialect, line)?;
        if text.trim().is_empty() { Ok(()) } else { Err(LineCursor::new(self.dialect, &text).no_word()) }
    }

    /// `%` begins and ends a codec.
    fn percent(&mut self, here: SourcePosition, next: SourcePosition) -> Result<(), ReadFault> {
        let is_main = self.dialect == Dialect::LinuxCnc && self.file == 0;
        match (self.begun, self.codec) {
            (false, false) => {
                (self.codec, self.begun) = (true, true);
                if let Some(main) = self.found.first_mut().filter(|_| is_main) {
                    main.start = next;
                }
                Ok(())
            }
            (true, true) if !self.over => {
                self.over = true;
                if self.dialect == Dialect::LinuxCnc && self.open {
                    return Err(ReadFault::NoEnd { end: "endsub" });
                }
                if let Some(main) = self.found.first_mut().filter(|_| is_main) {
                    main.end = here.at;
                }
                self.close(here, next);
                Ok(())
            }
            _ => Err(ReadFault::NoWord { text: "%".into() }),
        }
    }

    /// The program that is open ends before a place.
    fn close(&mut self, here: SourcePosition, next: SourcePosition) {
        let open = core::mem::take(&mut self.open);
        if let Some(last) = self.found.last_mut().filter(|_| open) {
            (last.end, last.after) = (here.at, next);
        }
    }

    /// `o<name> sub` to `o<name> endsub`.
    fn o_line(&mut self, line: &str, here: SourcePosition, next: SourcePosition) -> Result<(), ReadFault> {
        let text = words::without_comments(self.dialect, line)?;
        let mut cursor = LineCursor::new(self.dialect, &text);
        let (name, keyword) = o_word(&mut cursor)?;
        let refused = |why| Err(ReadFault::Refused { word: format!("o<{name}>"), why });
        match keyword {
            OWord::Call => return Ok(()),
            OWord::Sub if self.open => return refused("a subprogram begins within another"),
            OWord::Sub => {
                if self.file > 0 && !self.file_name.eq_ignore_ascii_case(&format!("{name}.ngc")) {
                    return refused("a subprogram of a file of its own must have the file's name");
                }
                self.open = true;
                self.store(name, next, Vec::new());
            }
            OWord::EndSub if !self.open => return refused("a subprogram ends that was not begun"),
            OWord::EndSub => {
                if self.found.last().is_some_and(|last| last.name != name) {
                    return refused("it ends a subprogram of another name");
                }
                self.close(here, next);
            }
        }
        if cursor.peek().is_some() { Err(cursor.no_word()) } else { Ok(()) }
    }

    /// `O1001 (title)` begins a program.
    fn number_line(&mut self, line: &str, here: SourcePosition, next: SourcePosition) -> Result<(), ReadFault> {
        self.close(here, here);
        let text = words::without_comments(self.dialect, line)?;
        let digits = text.trim().trim_start_matches(['O', 'o']);
        let number = digits.parse::<u32>().ok().filter(|number| digits.len() <= 8 && *number > 0);
        let Some(number) = number else { return Err(LineCursor::new(self.dialect, &text).no_word()) };
        self.store(number.to_string(), next, Vec::new());
        self.open = true;
        Ok(())
    }

    /// `PROC NAME(REAL A, REAL B)` begins a subprogram; comments may stand before it.
    fn proc_line(&mut self, line: &str, next: SourcePosition) -> Result<(), ReadFault> {
        let text = words::without_comments(self.dialect, line)?;
        let mut cursor = LineCursor::new(self.dialect, &text);
        if cursor.peek().is_none() {
            return Ok(());
        }
        let fault = cursor.no_word();
        if !cursor.name().eq_ignore_ascii_case("PROC") {
            return Err(fault);
        }
        let name = cursor.name().to_ascii_uppercase();
        let mut parameters = Vec::new();
        if name.is_empty() {
            return Err(fault);
        }
        if !self.file_name.eq_ignore_ascii_case(&format!("{name}.SPF")) {
            return Err(ReadFault::Refused {
                word: format!("PROC {name}"),
                why: "the file must have its name and .SPF",
            });
        }
        if cursor.skip_if(b'(') && !cursor.skip_if(b')') {
            loop {
                let is_real = cursor.name().eq_ignore_ascii_case("REAL");
                let parameter = cursor.name().to_ascii_uppercase();
                if !is_real || parameter.is_empty() || parameters.contains(&parameter) {
                    return Err(fault);
                }
                parameters.push(parameter);
                if cursor.skip_if(b')') {
                    break;
                }
                if !cursor.skip_if(b',') || parameters.len() >= super::MAX_PARAMETERS {
                    return Err(fault);
                }
            }
        }
        if cursor.peek().is_some() {
            return Err(cursor.no_word());
        }
        self.store(name, next, parameters);
        self.open = true;
        Ok(())
    }

    fn finish(&mut self, place: SourcePosition) -> Result<(), ReadFault> {
        if self.codec && !self.over {
            return Err(ReadFault::NoEnd { end: "%" });
        }
        if self.dialect == Dialect::LinuxCnc && self.open {
            return Err(ReadFault::NoEnd { end: "endsub" });
        }
        self.close(place, place);
        Ok(())
    }
}

/// Returns whether a line declares a subprogram with `EXTERN`; the subprogram must exist with the same number of
/// parameters.
pub(super) fn declares(library: &SubprogramLibrary<'_>, cursor: &mut LineCursor<'_>) -> Result<bool, ReadFault> {
    let fault = cursor.no_word();
    let line = cursor.rest;
    if !cursor.name().eq_ignore_ascii_case("EXTERN") {
        cursor.rest = line;
        return Ok(false);
    }
    let name = cursor.name().to_ascii_uppercase();
    let mut passed = 0;
    if cursor.skip_if(b'(') {
        loop {
            if !cursor.name().eq_ignore_ascii_case("REAL") {
                return Err(fault);
            }
            passed += 1;
            if cursor.skip_if(b')') {
                break;
            }
            if !cursor.skip_if(b',') {
                return Err(fault);
            }
        }
    }
    if cursor.peek().is_some() {
        return Err(cursor.no_word());
    }
    let declared = library.programs[library.find(&name)?].parameters.len();
    if passed == declared { Ok(true) } else { Err(ReadFault::Parameters { name, passed, declared }) }
}
