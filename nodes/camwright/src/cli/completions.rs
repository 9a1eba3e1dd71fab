// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright completions` and `camwright man`: shell completions and man pages from the definitions of the commands.

use super::output::{print_error, say};
use super::{Cli, help};
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `camwright completions`.
#[derive(Debug, Clone, Args)]
#[command(after_help = help::COMPLETIONS)]
pub(super) struct CompletionsArgs {
    /// Shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Arguments of `camwright man`.
#[derive(Debug, Clone, Args)]
#[command(after_help = help::MAN)]
pub(super) struct ManArgs {
    /// Folder for the pages; it is created if it does not exist.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Prints the completions of a shell.
pub(super) fn completions(args: &CompletionsArgs) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "camwright", &mut script);
    say!("{}", String::from_utf8_lossy(&script).trim_end());
    ExitCode::SUCCESS
}

/// Writes one man page for each command. Exit code 0: written; 1: not written.
pub(super) fn man(args: &ManArgs) -> ExitCode {
    let mut program = Cli::command();
    program.build();
    match std::fs::create_dir_all(&args.folder).and_then(|()| write_pages(&program, &args.folder)) {
        Ok(count) => {
            say!("written: {count} pages in {}", args.folder.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error("camwright man", &format!("{} cannot be written: {error}", args.folder.display()));
            ExitCode::from(1)
        }
    }
}

/// Writes the page of a command and those of its subcommands; returns their number.
fn write_pages(command: &Command, folder: &Path) -> std::io::Result<usize> {
    let page = Man::new(command.clone()).manual("camwright");
    std::fs::write(folder.join(page.get_filename()), rendered(command, &page)?)?;
    let inner = command.get_subcommands().filter(|command| command.get_name() != "help");
    inner.map(|command| write_pages(command, folder)).sum::<std::io::Result<usize>>().map(|count| count + 1)
}

/// Sections of a man page. Examples and exit codes keep their lines.
fn rendered(command: &Command, page: &Man) -> std::io::Result<Vec<u8>> {
    let mut text = Vec::new();
    page.render_title(&mut text)?;
    page.render_name_section(&mut text)?;
    page.render_synopsis_section(&mut text)?;
    page.render_description_section(&mut text)?;
    page.render_options_section(&mut text)?;
    if command.has_subcommands() {
        page.render_subcommands_section(&mut text)?;
    }
    let after = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let (examples, codes) = after.split_at(after.find("Exit codes").unwrap_or(after.len()));
    let mut roff = Roff::new();
    for (heading, titles, lines) in [
        ("EXAMPLES", &["Examples:\n", "Example: "][..], examples),
        ("EXIT STATUS", &["Exit codes:\n", "Exit codes: "], codes),
    ] {
        let lines = titles.iter().find_map(|title| lines.strip_prefix(title)).unwrap_or(lines);
        roff.control("SH", [heading]).control("nf", []);
        for line in lines.trim_end().lines() {
            roff.text([roman(line)]);
        }
        roff.control("fi", []);
    }
    roff.to_writer(&mut text)?;
    Ok(text)
}
