// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Text for a terminal of 80 columns.

/// Columns of a terminal; results fit in them.
const COLUMNS: usize = 80;

/// Breaks each line at spaces to fit 80 columns and indents the lines that follow. Words longer than a line, such as paths, stay whole.
#[must_use]
pub fn wrapped(text: &str, indent: usize) -> String {
    text.lines().map(|line| wrapped_line(line, indent)).collect::<Vec<_>>().join("\n")
}

fn wrapped_line(line: &str, indent: usize) -> String {
    let mut lines = Vec::new();
    let mut rest = line.to_owned();
    while rest.chars().count() > COLUMNS {
        // A break within the leading spaces would add no word to the line.
        let begin = rest.len() - rest.trim_start().len();
        let mut breaks = rest.char_indices().enumerate().filter(|(_, (at, c))| *c == ' ' && *at > begin);
        let fits = breaks.clone().take_while(|(column, _)| *column <= COLUMNS).last();
        let Some((_, (at, _))) = fits.or_else(|| breaks.next()) else { break };
        lines.push(rest[..at].trim_end().to_owned());
        rest = format!("{:indent$}{}", "", rest[at..].trim_start());
    }
    lines.push(rest);
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_at_spaces_and_long_words_stay_whole() {
        let words = "word ".repeat(40);
        let text = wrapped(words.trim_end(), 4);
        assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{text}");
        assert!(text.lines().skip(1).all(|line| line.starts_with("    word")), "{text}");
        assert_eq!(text.split_whitespace().count(), 40);
        let path = "x".repeat(100);
        assert_eq!(wrapped(&format!("bag: {path}"), 2), format!("bag:\n  {path}"));
        assert_eq!(wrapped(&path, 2), path);
        let exact = "y".repeat(COLUMNS);
        assert_eq!(wrapped(&exact, 2), exact);
        assert_eq!(wrapped(&format!("{}µ {exact}", "µ".repeat(78)), 0), format!("{}µ\n{exact}", "µ".repeat(78)));
    }
}
