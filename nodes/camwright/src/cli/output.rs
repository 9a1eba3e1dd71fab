//! Results of the command line on standard output.

use camwright_planning::AnyPrepared;
use std::fmt::Arguments;
use std::io::Write as _;

/// Writes a line. A reader that has closed the pipe, as `head` does, gets no more lines; the command goes on and keeps its exit code.
pub(super) fn write_line(line: Arguments<'_>) {
    let _reader_is_gone = writeln!(std::io::stdout(), "{line}");
}

/// Prints the warnings about a planned job on standard error.
pub(super) fn print_warnings(prepared: &AnyPrepared) {
    for finding in prepared.warnings() {
        let _reader_is_gone = writeln!(std::io::stderr(), "{finding}");
    }
}

/// Prints a line of the result, as `println!` does, but does not panic on a closed pipe.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::cli::output::write_line(format_args!($($text)*))
    };
}
pub(super) use camwright_bag::terminal::wrapped;
pub(super) use say;
