// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Alarms of the run, and messages that were lost.

use super::findings::Findings;
use super::table::table;
use super::text::fixed;
use camwright_msgs::camwright_msgs::msg::Alarm;
use camwright_planning::markup::escape;
use std::fmt::Write as _;

pub(super) fn write(out: &mut String, findings: &Findings<'_>) {
    out.push_str("<section id=\"alarms\"><h2>Alarms</h2>");
    let recorded = findings.recorded;
    if recorded.alarms.is_empty() {
        out.push_str("<p>None.</p>");
    } else {
        let row = |record: &super::gather::AlarmRecord| {
            let alarm = &record.alarm;
            let severity = match alarm.severity {
                Alarm::WARNING => "warning",
                Alarm::STOP => "stop",
                _ => "power off",
            };
            let at = findings.seconds(alarm.tick).map_or_else(|| "–".into(), |at| fixed(at, 3));
            vec![
                at,
                alarm.number.to_string(),
                severity.to_owned(),
                escape(&alarm.source),
                escape(&alarm.text),
                escape(&alarm.remedy),
                record.gone.map_or_else(|| "no".into(), |tick| format!("at tick {tick}")),
            ]
        };
        let heads = [
            ("at s", false),
            ("number", false),
            ("reaction", true),
            ("source", true),
            ("what", true),
            ("what to do", true),
            ("reset", true),
        ];
        table(out, &heads, &recorded.alarms.iter().map(row).collect::<Vec<_>>());
    }
    out.push_str("</section>\n<section id=\"losses\"><h2>Losses</h2><ul>");
    for line in losses(findings) {
        let _infallible = write!(out, "<li>{}</li>", escape(&line));
    }
    out.push_str("</ul></section>\n");
}

/// Missing data of the bag, a sentence each; also a sentence if nothing is missing.
fn losses(findings: &Findings<'_>) -> Vec<String> {
    let recorded = findings.recorded;
    let custom = |key: &str| recorded.custom.get(key).map(String::as_str);
    let mut lines = Vec::new();
    lines.push(match custom("camwright.outcome") {
        Some("complete") => "The recording was closed as it should be.".to_owned(),
        Some("fault") => {
            format!("The recording ended by a fault: {}.", custom("camwright.fault").unwrap_or("not said"))
        }
        Some("recovered") => format!(
            "The bag was recovered from a damaged one: {}.",
            custom("camwright.recovered").unwrap_or("losses are not recorded")
        ),
        Some("open") => "The recording was never closed: it was killed, or still runs.".to_owned(),
        Some(other) => format!("Outcome of the recording: {other}."),
        None => "The end of the recording is not recorded.".to_owned(),
    });
    if !recorded.is_closed {
        lines.push("A storage file has no end; its intact part was read.".to_owned());
    }
    lines.push(match custom("camwright.lost_total") {
        Some("0") => "No message was lost between the network and the file.".to_owned(),
        Some(count) => format!("{count} messages were lost between the network and the file."),
        None => match &recorded.recorder {
            Some(status) => format!("{} messages were lost by the last status of the recorder.", status.dropped),
            None => "Lost messages are not recorded.".to_owned(),
        },
    });
    for gap in &recorded.gaps {
        lines.push(format!("{}: {} messages are missing by their numbers.", gap.topic, gap.missing));
    }
    for (topic, (count, reason)) in &recorded.unread {
        lines.push(format!("{topic}: {count} messages could not be understood ({reason})."));
    }
    lines.push(match findings.motion {
        Some(motion) if motion.missing == 0 => {
            format!("Every one of the job's {} ticks has its joint state.", motion.ticks)
        }
        Some(motion) => format!("{} of the job's {} ticks have no joint state.", motion.missing, motion.ticks),
        None => "The axes' ticks are not recorded.".to_owned(),
    });
    lines
}
