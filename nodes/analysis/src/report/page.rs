//! The page: what is said first, and behind it everything that it rests on.

use super::text::escape;
use super::{Findings, alarms, gauging, head, lobes, provenance, time_line, turned};

/// The page's look, for screens that are light or dark and for paper.
const STYLE: &str = include_str!("style.css");

pub(super) fn html(findings: &Findings<'_>) -> String {
    let job = findings.story.status.map_or("", |status| &status.job);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
         <title>{}: {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n",
        escape(job),
        findings.verdict.word
    );
    head::write(&mut out, findings);
    lobes::table(&mut out, findings);
    turned::write(&mut out, findings);
    gauging::write(&mut out, findings);
    lobes::figures(&mut out, findings);
    time_line::write(&mut out, findings);
    alarms::write(&mut out, findings);
    provenance::write(&mut out, findings);
    out.push_str("</main>\n</body>\n</html>\n");
    out
}

/// A table: what stands above the columns, whether they are text, and the rows as HTML.
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
