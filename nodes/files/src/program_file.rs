// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The NC program that a job is ground by: the key `program`.

use super::job_files::JobFiles;
use super::nc_file::NcSettings;
use super::yaml::Document;
use super::{ConfigError, FileLocation};
use camwright::gcode::{Dialect, ProgramFile, ProgramMotion, read as read_program};
use std::path::{Path, PathBuf};

/// Plural name of program files.
const PROGRAMS: &str = "programs";

/// A program that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct JobProgram {
    pub motion: ProgramMotion,
    /// Its files, the main program first.
    pub files: Vec<ProgramFile>,
}

/// Finds and reads the program that a job names, with the control and the X values that its key `nc` says.
pub(super) fn read(
    name: &str,
    document: &Document,
    nc: &NcSettings,
    files_of_job: &mut JobFiles,
) -> Result<JobProgram, ConfigError> {
    let dialect = nc.control.dialect;
    let extension = match dialect {
        Dialect::LinuxCnc => "ngc",
        Dialect::Fanuc => "NC",
        Dialect::Siemens => "MPF",
    };
    let main = document.locate(PROGRAMS, name, extension)?;
    files_of_job.add(PROGRAMS, name, main.text.as_bytes());
    let mut paths = vec![main.path.clone()];
    let mut files = vec![ProgramFile { name: file_name(&main.path), text: main.text }];
    if dialect == Dialect::Siemens {
        for path in subprograms(document, &main.path, &files[0].text)? {
            let name = path.display().to_string();
            let located = document.locate(PROGRAMS, &name, "SPF")?;
            files_of_job.add(PROGRAMS, &name, located.text.as_bytes());
            files.push(ProgramFile { name: file_name(&located.path), text: located.text });
            paths.push(located.path);
        }
    }
    let read = read_program(dialect, nc.control.format.x_values(), &files);
    let motion = read.map_err(|error| {
        let named = files.iter().position(|file| file.name == error.file);
        let path = named.and_then(|index| paths.get(index)).unwrap_or(&main.path);
        ConfigError::at(FileLocation::line(path, u64::from(error.line)), error.fault.to_string())
    })?;
    Ok(JobProgram { motion, files })
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Subprograms of a SINUMERIK are files of their own: those beside the main program that it names.
fn subprograms(document: &Document, main: &Path, text: &str) -> Result<Vec<PathBuf>, ConfigError> {
    let recorded: Vec<PathBuf> = document.recorded.names(PROGRAMS).map(PathBuf::from).collect();
    let beside = if recorded.is_empty() {
        let folder = main.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let entries = std::fs::read_dir(folder);
        let entries =
            entries.map_err(|error| ConfigError::at(FileLocation::file(folder), format!("cannot be read: {error}")))?;
        entries.filter_map(Result::ok).map(|entry| entry.path()).collect()
    } else {
        recorded
    };
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: Vec<&str> = text.split(|c| !word(c)).collect();
    let is_named = |path: &PathBuf| {
        let is_sub = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("spf"));
        let stem = path.file_stem().map(|stem| stem.to_string_lossy());
        is_sub && stem.is_some_and(|stem| words.iter().any(|word| word.eq_ignore_ascii_case(&stem)))
    };
    let mut paths: Vec<PathBuf> = beside.into_iter().filter(is_named).collect();
    paths.sort();
    Ok(paths)
}
