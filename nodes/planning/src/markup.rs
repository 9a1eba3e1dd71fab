// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Text in HTML and SVG.

/// Escaped text for a page or a drawing. A sign replaces control characters, which HTML does not allow.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_recorded_text_becomes_part_of_the_page() {
        let text = "<script>alert(\"1\" & '2')</script>\u{0}\u{85}\n";
        let escaped = escape(text);
        assert_eq!(escaped, "&lt;script&gt;alert(&quot;1&quot; &amp; &#39;2&#39;)&lt;/script&gt;\u{fffd}\u{fffd}\n");
    }
}
