// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The page: what is said first, and behind it everything that it rests on.

use super::findings::Findings;
use super::{alarms, gauge_size, gauging, head, inspection, lobes, pins, provenance, time_line, turned};
use camwright_planning::markup::escape;

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
    pins::table(&mut out, findings);
    gauge_size::table(&mut out, findings);
    inspection::table(&mut out, findings);
    turned::write(&mut out, findings);
    gauging::write(&mut out, findings);
    lobes::figures(&mut out, findings);
    time_line::write(&mut out, findings);
    alarms::write(&mut out, findings);
    provenance::write(&mut out, findings);
    out.push_str("</main>\n</body>\n</html>\n");
    out
}
