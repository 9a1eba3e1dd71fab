// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sources of the report: job, hashes, versions, files, and the job itself.

use super::findings::Findings;
use super::table::table;
use super::text::fixed;
use camwright_bag::info::utc;
use camwright_msgs::camwright_msgs::msg::{JobStatus, PlanHeader};
use camwright_planning::markup::escape;
use std::fmt::Write as _;

pub(super) fn write(out: &mut String, findings: &Findings<'_>) {
    earlier(out, findings);
    out.push_str("<section id=\"provenance\"><h2>Provenance</h2><table><tbody>");
    for (what, value) in facts(findings) {
        let _infallible =
            write!(out, "<tr><td class=\"text\">{}</td><td class=\"hash\">{}</td></tr>", escape(&what), escape(&value));
    }
    out.push_str("</tbody></table></section>\n");
    let source = findings.story.status.map_or("", |status| &status.job_source);
    if !source.is_empty() {
        let _infallible = writeln!(
            out,
            "<section id=\"job\"><h2>The job as it was planned</h2><pre>{}</pre></section>",
            escape(source)
        );
    }
}

/// The other jobs of the bag.
fn earlier(out: &mut String, findings: &Findings<'_>) {
    let ended = &findings.story.ended;
    if ended.len() < 2 {
        return;
    }
    let row = |(index, ended): (usize, &super::job_timeline::EndedJob)| {
        let status = &ended.status;
        let state = match status.state {
            JobStatus::COMPLETE => "complete",
            JobStatus::STOPPED => "cancelled",
            _ => "aborted or refused",
        };
        let lobes = status.lobes.iter().map(|lobe| lobe.form_error_max.abs());
        let worst = lobes.chain(status.turned.iter().map(|part| part.form_error_max.abs())).fold(0.0, f64::max);
        let here = if ended.is_last { ", this report" } else { "" };
        let worst = if worst > 0.0 { fixed(super::text::um(worst), 2) } else { "–".into() };
        vec![
            (index + 1).to_string(),
            format!("{}{here}", escape(&status.job)),
            state.to_owned(),
            worst,
            escape(&status.message),
        ]
    };
    out.push_str("<section id=\"parts\"><h2>Jobs in this bag</h2>");
    let heads = [("", false), ("job", true), ("ended", true), ("worst error µm", false), ("message", true)];
    table(out, &heads, &ended.iter().enumerate().map(row).collect::<Vec<_>>());
    out.push_str("</section>\n");
}

fn facts(findings: &Findings<'_>) -> Vec<(String, String)> {
    let recorded = findings.recorded;
    let missing = || "not recorded".to_owned();
    let or_missing = |text: &str| if text.is_empty() { missing() } else { text.to_owned() };
    let status = findings.story.status;
    let mut facts = vec![
        ("job".to_owned(), or_missing(status.map_or("", |status| &status.job))),
        (
            "hash of the job with everything it names".to_owned(),
            or_missing(status.map_or("", |status| &status.job_hash)),
        ),
    ];
    for (hash, header) in &findings.story.plans {
        let half = match header.half {
            PlanHeader::FIRST => ", first part of the job",
            PlanHeader::MIDDLE => ", middle part of the job",
            PlanHeader::SECOND => ", last part of the job",
            PlanHeader::NO_PART => ", finishes no part",
            _ => "",
        };
        facts.push((format!("plan, by planner {}{half}", header.version), hash.clone()));
    }
    facts.push((
        "planned again for this report".to_owned(),
        match findings.again {
            Ok(_) => "yes, to the same plan: Q′, planned speeds and limits are those that were driven".to_owned(),
            Err(reason) => format!("no: {reason}. Data that only a plan holds are missing"),
        },
    ));
    match findings.story.machine {
        Some(machine) => {
            facts.push((format!("machine {}", machine.name), machine.hash.clone()));
            let radius = fixed(camwright_files::convert::mm_from_m(machine.wheel_radius), 4);
            facts.push(("tool when the job was planned".to_owned(), format!("radius {radius} mm")));
        }
        None => facts.push(("machine".to_owned(), missing())),
    }
    let run = &recorded.custom;
    for (key, what) in [
        ("camwright.version", "recorded by camwright"),
        ("camwright.target", "on"),
        ("camwright.run_id", "run"),
        ("camwright.wall_start_utc", "recording began (computer's clock)"),
    ] {
        if let Some(value) = run.get(key) {
            facts.push((what.to_owned(), value.clone()));
        }
    }
    if let Some((first, last)) = recorded.span_ns {
        let seconds = (last - first) as f64 * 1e-9;
        facts
            .push(("times in the bag".to_owned(), format!("{} to {}, {} s", utc(first), utc(last), fixed(seconds, 3))));
    }
    facts.push(("messages".to_owned(), format!("{} on {} topics", recorded.messages, recorded.topics)));
    for file in &recorded.files {
        facts.push((format!("{}, {} bytes, SHA-256", file.name, file.bytes), file.sha256.clone()));
    }
    facts.push(("report made by camwright".to_owned(), env!("CARGO_PKG_VERSION").to_owned()));
    facts
}
