// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of the page.

use camwright_planning::markup::escape;

/// Writes a table. Each head has the flag of a text column; rows are HTML.
pub(super) fn table(out: &mut String, heads: &[(&str, bool)], rows: &[Vec<String>]) {
    let class = |is_text: bool| if is_text { " class=\"text\"" } else { "" };
    out.push_str("<table><thead><tr>");
    for (head, is_text) in heads {
        out.push_str(&format!("<th{}>{}</th>", class(*is_text), escape(head)));
    }
    out.push_str("</tr></thead><tbody>");
    for row in rows {
        out.push_str("<tr>");
        for (cell, (_, is_text)) in row.iter().zip(heads) {
            out.push_str(&format!("<td{}>{cell}</td>", class(*is_text)));
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table>");
}
