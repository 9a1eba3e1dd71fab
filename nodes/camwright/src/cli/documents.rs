// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Documents of the command line: the reference page is generated from the definitions, and every documented command parses.

use super::Cli;
use camwright_ros::RosArgs;
use clap::error::ErrorKind;
use clap::{Arg, Command, CommandFactory, Parser};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Environment variable that makes the test write the reference page.
const WRITE: &str = "CAMWRIGHT_WRITE_REFERENCE";

const PAGE: &str = "docs/reference/command_line.md";

const HEAD: &str = "# Command line

Generated from the definitions of the commands. `--help` prints the same on the terminal.

Results are at most 80 columns wide: first the verdict, then one line per lobe, then the files. [Exit codes](exit_codes.md) lists the codes
that all commands share. `--quiet` and `--color` work with every command, and ROS arguments after `--ros-args`.

| command | purpose |
|---|---|
";

/// Folders whose documents are not part of the project.
const SKIPPED: [&str; 2] = ["target", "node_modules"];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Text outside of code quotes, safe in a cell of a Markdown table.
fn cell(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let escaped = parts.map(|(index, part)| if index % 2 == 0 { part.replace('<', "\\<") } else { part.to_owned() });
    escaped.collect::<Vec<_>>().join("`").replace('|', "\\|").replace('\n', " ")
}

/// Row of the table of arguments. A default that only the help states moves to its column.
fn row(argument: &Arg) -> String {
    let short = argument.get_short().map(|short| format!("`-{short}`, ")).unwrap_or_default();
    let name = argument.to_string().replace('|', "\\|");
    let help = argument.get_long_help().or(argument.get_help()).map(ToString::to_string).unwrap_or_default();
    let (help, stated) =
        help.trim_end_matches('.').split_once(" [default: ").unwrap_or((help.trim_end_matches('.'), ""));
    let values = argument.get_possible_values();
    let names: Vec<&str> = values.iter().filter(|value| !value.is_hide_set()).map(|value| value.get_name()).collect();
    let is_choice = argument.get_action().takes_values() && !names.is_empty();
    let choice = if is_choice { format!(" Values: `{}`.", names.join("`, `")) } else { String::new() };
    let defaults: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let default = defaults.join(" ");
    let default = match default.as_str() {
        "" => cell(stated.trim_end_matches(']')),
        _ if !argument.get_action().takes_values() => String::new(),
        value => format!("`{value}`"),
    };
    format!("| {short}`{name}` | {}.{choice} | {default} |\n", cell(help))
}

/// Appends the section of a command and those of its subcommands.
fn write_command(command: &mut Command, level: usize, page: &mut String) -> std::fmt::Result {
    let name = command.get_bin_name().unwrap_or_else(|| command.get_name()).to_owned();
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let usage = command.render_usage().to_string();
    write!(page, "\n{} {name}\n\n{}.\n\n", "#".repeat(level), about.trim_end_matches('.'))?;
    write!(page, "```text\n{}\n```\n", usage.trim())?;
    // Every command has these; the section of the program lists them.
    let is_common = |id: &str| name.contains(' ') && ["quiet", "color"].contains(&id);
    let is_listed = |argument: &&Arg| {
        let id = argument.get_id().as_str();
        !argument.is_hide_set() && !["help", "version"].contains(&id) && !is_common(id)
    };
    let rows: String = command.get_arguments().filter(is_listed).map(row).collect();
    if !rows.is_empty() {
        write!(page, "\n| argument | meaning | default |\n|---|---|---|\n{rows}")?;
    }
    if let Some(after) = command.get_after_help() {
        write!(page, "\n```text\n{}\n```\n", after.to_string().trim())?;
    }
    for subcommand in command.get_subcommands_mut().filter(|command| command.get_name() != "help") {
        // The commands of the program are sections beside its own.
        let is_nested = name.contains(' ');
        write_command(subcommand, level + usize::from(is_nested), page)?;
    }
    Ok(())
}

/// Reference page of all commands.
fn page() -> String {
    let mut program = Cli::command();
    program.build();
    let mut page = HEAD.to_owned();
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        let (name, about) = (command.get_name(), command.get_about().map(ToString::to_string).unwrap_or_default());
        let about = about.trim_end_matches('.');
        writeln!(page, "| [`camwright {name}`](#camwright-{name}) | {} |", cell(about)).expect("a string takes it");
    }
    write_command(&mut program, 2, &mut page).expect("a string takes it");
    page
}

#[test]
fn the_reference_of_the_command_line_is_what_the_program_defines() {
    let (path, page) = (repository().join(PAGE), page());
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&path, &page).expect("the repository is writable");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "{PAGE} is out of date; write it with {WRITE}=1 cargo test -p camwright_nodes --lib reference_of_the_command_line"
    );
}

/// Words of a shell command up to the first operator or comment.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for letter in line.chars() {
        match (quote, letter) {
            (Some(open), _) if letter == open => quote = None,
            (None, '\'' | '"') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None, '>') => {
                // The number of what is redirected.
                word = word.filter(|word| word.parse::<u8>().is_err());
                break;
            }
            (None, '|' | ';' | '&') => break,
            (None, '#') if word.is_none() => break,
            (None, _) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    words
}

/// Commands in the fenced blocks of a document, and commands in its code quotes.
fn commands(text: &str) -> (Vec<String>, Vec<String>) {
    let (mut blocks, mut prose, mut is_block) = (String::new(), String::new(), false);
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_block = !is_block;
        } else {
            let into = if is_block { &mut blocks } else { &mut prose };
            into.push_str(line);
            into.push('\n');
        }
    }
    let is_command = |line: &str| line == "camwright" || line.starts_with("camwright ");
    let blocks = blocks.replace("\\\n", " ");
    let lines = blocks.lines().map(|line| line.trim_start().trim_start_matches("$ ").trim_start_matches("Example: "));
    let quotes = prose.split('`').skip(1).step_by(2).map(|quote| quote.replace('\n', " ").replace("\\|", "|"));
    (
        lines.filter(|line| is_command(line)).map(str::to_owned).collect(),
        quotes.filter(|quote| is_command(quote)).collect(),
    )
}

/// Reason why a documented command does not parse. In prose required arguments may be missing.
fn parse_error(command: &str, is_prose: bool) -> Option<String> {
    let words = words(command);
    let (_, rest) = RosArgs::parse(&words).map_err(|error| error.to_string()).ok()?;
    let error = Cli::try_parse_from(rest).err()?;
    let is_incomplete = match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => true,
        ErrorKind::MissingRequiredArgument
        | ErrorKind::MissingSubcommand
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => is_prose,
        _ => false,
    };
    (!is_incomplete).then(|| error.to_string())
}

fn documents(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the repository").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() && !SKIPPED.contains(&&*name) && !name.starts_with('.') {
            documents(&path, into);
        } else if name.ends_with(".md") {
            into.push(path);
        }
    }
}

#[test]
fn every_documented_command_parses() {
    let mut all = Vec::new();
    documents(&repository(), &mut all);
    let (mut count, mut wrong) = (0, Vec::new());
    for document in &all {
        let text = std::fs::read_to_string(document).expect("a document");
        let (blocks, quotes) = commands(&text);
        let blocks = blocks.iter().map(|command| (command, false));
        for (command, is_prose) in blocks.chain(quotes.iter().map(|command| (command, true))) {
            count += 1;
            if let Some(error) = parse_error(command, is_prose) {
                let error = error.lines().next().unwrap_or_default();
                wrong.push(format!("{}: `{command}`: {error}", document.display()));
            }
        }
    }
    assert!(count > 100, "only {count} commands were found in {} documents", all.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_command_that_does_not_exist_is_reported() {
    assert_eq!(words("camwright run 'a b' --set x=\"1 2\" # note"), ["camwright", "run", "a b", "--set", "x=1 2"]);
    assert_eq!(words("camwright urdf lathe > lathe.urdf"), ["camwright", "urdf", "lathe"]);
    assert!(parse_error("camwright grind eccentric", true).is_some());
    assert!(parse_error("camwright run eccentric --fast", true).is_some());
    assert!(parse_error("camwright bag check", true).is_none() && parse_error("camwright bag check", false).is_some());
    assert!(parse_error("camwright status --ros-args -r __ns:=/cell_2", false).is_none());
}
