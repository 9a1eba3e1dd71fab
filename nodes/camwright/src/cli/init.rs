// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright init`: writes a commented file to start from.

use super::output::{print_error, say};
use camwright_files::file_kind::FileKind;
use camwright_files::starter::starter_name;
use clap::{Args, ValueEnum};
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Kinds of files that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Grinding job.
    Job,
    /// Machine.
    Machine,
    /// Turning job.
    Turning,
    /// Milling job.
    Milling,
    /// Study: cases of a job.
    Study,
}

/// Arguments of `camwright init`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::INIT)]
pub(super) struct InitArgs {
    /// Kind of the file.
    #[arg(value_enum)]
    kind: Kind,
    /// File to write; `-` prints it [default: my_<kind>.yaml].
    file: Option<PathBuf>,
    /// Print the file instead of writing it.
    #[arg(long)]
    print: bool,
}

impl Kind {
    const fn file_kind(self) -> FileKind {
        match self {
            Self::Job => FileKind::Job,
            Self::Machine => FileKind::Machine,
            Self::Turning => FileKind::TurningJob,
            Self::Milling => FileKind::MillingJob,
            Self::Study => FileKind::Study,
        }
    }

    /// Name of the file, if the user gives none.
    fn default_file(self) -> PathBuf {
        let kind = self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        PathBuf::from(format!("my_{kind}.yaml"))
    }

    /// Command for the file after its check.
    fn next(self, file: &str) -> String {
        match self {
            Self::Job | Self::Turning => format!("camwright run {file}"),
            Self::Machine => format!("camwright run four_lobe_camshaft --set machine={file}"),
            Self::Study => format!("camwright study {file}"),
            Self::Milling => format!("camwright post {file} --out nc"),
        }
    }
}

/// Exit code 0: written; 1: not written.
pub(super) fn main(args: &InitArgs) -> ExitCode {
    match init(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print_error("camwright init", &error);
            ExitCode::from(1)
        }
    }
}

/// Writes a file that must not exist yet.
pub(super) fn write_new(path: &Path, text: &str) -> Result<(), String> {
    let shown = path.display();
    let mut file = OpenOptions::new().write(true).create_new(true).open(path).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => format!("{shown} exists and is not overwritten; remove it or name another file"),
        ErrorKind::NotFound => format!("{shown} cannot be written: its folder does not exist; create the folder first"),
        _ => format!("{shown} cannot be written: {error}; name a file in a folder that you can write to"),
    })?;
    file.write_all(text.as_bytes()).map_err(|error| format!("{shown} cannot be written: {error}"))
}

fn init(args: &InitArgs) -> Result<(), String> {
    let path = args.file.clone().unwrap_or_else(|| args.kind.default_file());
    let is_printed = args.print || path == Path::new("-");
    let named = if path == Path::new("-") { args.kind.default_file() } else { path.clone() };
    let stem = named.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let text = args.kind.file_kind().starter_file(&starter_name(&stem)).map_err(|error| error.to_string())?;
    if is_printed {
        say!("{}", text.trim_end());
        return Ok(());
    }
    let shown = path.display().to_string();
    write_new(&path, &text)?;
    say!("written: {shown}");
    say!("next:    camwright check {shown}");
    say!("         {}", args.kind.next(&shown));
    Ok(())
}
