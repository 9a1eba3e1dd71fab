// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Results, notes and errors of the command line, in colour where the reader shows colours.

use anstyle::{AnsiColor, Style};
use camwright_bag::progress;
use camwright_planning::AnyPrepared;
use clap::{Args, ColorChoice};
use std::fmt::{Arguments, Display};
use std::io::{IsTerminal as _, Write as _};
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by `--quiet`.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Arguments of every command about its output.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct OutputArgs {
    /// Print errors only; the exit code is the result.
    #[arg(long, short, global = true, display_order = 900)]
    quiet: bool,
    /// Colour verdicts, errors and warnings; `auto` does on a terminal without `NO_COLOR`.
    #[arg(long, global = true, value_enum, default_value_t = ColorChoice::Auto, value_name = "WHEN", display_order = 901)]
    color: ColorChoice,
}

/// Argument of a command whose result a script reads.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct JsonArg {
    /// Print the result as JSON on standard output.
    #[arg(long)]
    pub(super) json: bool,
}

/// Colours of a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VerdictLevel {
    Good,
    Warning,
    Bad,
}

impl VerdictLevel {
    /// Level of a result with this exit code, where 1 means warnings or not.
    pub(super) const fn from_code(code: u8) -> Self {
        if code == 0 { Self::Good } else { Self::Bad }
    }

    const fn style(self) -> Style {
        let color = match self {
            Self::Good => AnsiColor::Green,
            Self::Warning => AnsiColor::Yellow,
            Self::Bad => AnsiColor::Red,
        };
        color.on_default().bold()
    }

    /// Colours the words before the first colon.
    fn paint(self, text: &str) -> String {
        let (head, rest) = text.split_at(text.find(':').unwrap_or(text.len()));
        let style = self.style();
        format!("{style}{head}{style:#}{rest}")
    }
}

/// Applies the arguments to the whole process.
pub(super) fn apply(args: OutputArgs) {
    let choice = match args.color {
        ColorChoice::Always => anstream::ColorChoice::Always,
        ColorChoice::Never => anstream::ColorChoice::Never,
        ColorChoice::Auto => anstream::ColorChoice::Auto,
    };
    choice.write_global();
    QUIET.store(args.quiet, Ordering::Relaxed);
    if args.quiet {
        progress::hide_all();
    }
}

pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Choice of `--color` on a command line that is not parsed yet: clap colours help and errors with it.
pub(super) fn color_choice(words: &[String]) -> ColorChoice {
    let words = words.iter().take_while(|word| *word != "--");
    let mut chosen = ColorChoice::Auto;
    let mut is_value = false;
    for word in words {
        let value = if is_value { Some(&**word) } else { word.strip_prefix("--color=") };
        chosen = value.and_then(|value| value.parse().ok()).unwrap_or(chosen);
        is_value = word == "--color";
    }
    chosen
}

/// Writes a line of a result. A reader that has closed the pipe, as `head` does, gets no more lines; the command goes on and keeps its
/// exit code.
pub(super) fn write_line(line: Arguments<'_>) {
    if !is_quiet() {
        let _reader_is_gone = writeln!(anstream::stdout(), "{line}");
    }
}

/// Writes a note for the user, which is no result, on standard error.
pub(super) fn write_note(line: Arguments<'_>) {
    if !is_quiet() {
        let _reader_is_gone = writeln!(anstream::stderr(), "{line}");
    }
}

/// Prints a result whose first line is `VERDICT: …`.
pub(super) fn print_verdict(level: VerdictLevel, text: &str) {
    write_line(format_args!("{}", level.paint(text)));
}

/// Parses a number of the command line.
pub(super) fn number(text: &str) -> Result<f64, String> {
    let value: Result<f64, _> = text.trim().parse();
    value.ok().filter(|value| value.is_finite()).ok_or_else(|| format!("{text:?} is not a number, for example 0.5"))
}

/// Parses a whole number of the command line within a range.
pub(super) fn whole_number<T>(text: &str, range: RangeInclusive<T>) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    let value = text.trim().parse().ok().filter(|value| range.contains(value));
    value.ok_or_else(|| format!("it must be a whole number from {} to {}", range.start(), range.end()))
}

/// Prints `sender: message` on standard error, also with `--quiet`.
pub(super) fn print_error(sender: &str, message: &dyn Display) {
    let text = for_reader(&format!("{sender}: {message}"), std::io::stderr().is_terminal());
    let _reader_is_gone = writeln!(anstream::stderr(), "{}", VerdictLevel::Bad.paint(&text));
}

/// Prints a warning `sender: message` on standard error.
pub(super) fn print_warning(sender: &str, message: &dyn Display) {
    let text = for_reader(&format!("{sender}: {message}"), std::io::stderr().is_terminal());
    write_note(format_args!("{}", VerdictLevel::Warning.paint(&text)));
}

/// A message without the numbers that the operating system has for its errors; on a terminal in lines of 80 columns. Other readers
/// search in it, and get it whole.
fn for_reader(message: &str, is_terminal: bool) -> String {
    let (mut text, mut rest) = (String::new(), message);
    while let Some((before, behind)) = rest.split_once(" (os error ") {
        let Some((number, after)) = behind.split_once(')') else { break };
        let is_number = number.parse::<u32>().is_ok();
        text.push_str(before);
        if !is_number {
            text.push_str(&rest[before.len()..rest.len() - after.len()]);
        }
        rest = after;
    }
    text.push_str(rest);
    if is_terminal { wrapped(&text, 2) } else { text }
}

/// Prints the warnings about a planned job on standard error.
pub(super) fn print_warnings(prepared: &AnyPrepared) {
    for finding in prepared.warnings() {
        write_note(format_args!("{}", VerdictLevel::Warning.paint(&finding.to_string())));
    }
}

/// Prints a line of the result, as `println!` does, but does not panic on a closed pipe.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::cli::output::write_line(format_args!($($text)*))
    };
}

/// Prints a line for the user that is no result, on standard error.
macro_rules! note {
    ($($text:tt)*) => {
        $crate::cli::output::write_note(format_args!($($text)*))
    };
}
pub(super) use camwright_bag::terminal::wrapped;
pub(super) use {note, say};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_is_coloured_up_to_its_colon() {
        assert_eq!(VerdictLevel::Good.paint("GOOD: 3 um: fine"), "\u{1b}[1m\u{1b}[32mGOOD\u{1b}[0m: 3 um: fine");
        assert_eq!(VerdictLevel::Bad.paint("BURNT"), "\u{1b}[1m\u{1b}[31mBURNT\u{1b}[0m");
    }

    #[test]
    fn numbers_of_the_operating_system_are_left_out() {
        let error = std::io::Error::from_raw_os_error(13);
        assert_eq!(for_reader(&format!("a.yaml: {error}; b"), false), "a.yaml: Permission denied; b");
        for other in ["x (os error y) z", "x (os error 13", "x (os error 2)", ""] {
            assert_eq!(for_reader(other, false), if other.ends_with("2)") { "x" } else { other });
        }
        let long = "word ".repeat(40);
        assert_eq!(for_reader(&long, false), long);
        assert!(for_reader(&long, true).lines().all(|line| line.len() <= 80));
    }

    #[test]
    fn the_last_colour_choice_before_the_operands_counts() {
        let choice = |words: &str| color_choice(&words.split(' ').map(str::to_owned).collect::<Vec<_>>());
        assert_eq!(choice("camwright list jobs"), ColorChoice::Auto);
        assert_eq!(choice("camwright --color never list"), ColorChoice::Never);
        assert_eq!(choice("camwright list --color=never --color always"), ColorChoice::Always);
        assert_eq!(choice("camwright list -- --color=never"), ColorChoice::Auto);
        assert_eq!(choice("camwright --color purple"), ColorChoice::Auto);
    }
}
