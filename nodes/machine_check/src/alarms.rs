// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M30: what alarms say.

use super::observed::{Observed, alarm_numbers, sorted};
use super::report::ClauseReport;
use camwright::machine::alarm::AlarmKind;
use camwright_msgs::camwright_msgs::msg::{Alarm, MachineAlarms};

/// Numbers from here on are a machine's own.
const OWN: u16 = 1000;

/// Checks numbers, words, and the agreement of both topics.
pub(super) fn judge(observed: &Observed, report: &mut ClauseReport) {
    let before = report.evidence(30);
    let reported: Vec<&Alarm> = observed.alarms.iter().flat_map(|message| &message.alarms).collect();
    for alarm in &reported {
        let (number, tick) = (alarm.number, alarm.tick);
        if number < OWN && AlarmKind::from_number(number).is_none() {
            report.broken(30, format!("alarm {number} of tick {tick} is not in the table, and below {OWN}"));
        }
        for (what, text) in [("text", &alarm.text), ("remedy", &alarm.remedy)] {
            if text.trim().is_empty() {
                report.broken(30, format!("alarm {number} of tick {tick} has no {what}"));
            }
        }
        if !(Alarm::WARNING..=Alarm::POWER_OFF).contains(&alarm.severity) {
            report.broken(30, format!("alarm {number} of tick {tick} has severity {}, allowed 1 to 3", alarm.severity));
        }
    }
    if observed.alarms.is_empty() {
        report.not_seen(30, "machine/alarms was not received: it is latched, and empty where there are none");
    }
    agree(observed, report);
    if !reported.is_empty() {
        report.kept_unless_broken(
            30,
            before,
            format!("{} alarms reported, each with number, text and remedy", reported.len()),
        );
    }
}

/// Checks that both topics agree, once both have reported the same tick.
fn agree(observed: &Observed, report: &mut ClauseReport) {
    for pair in observed.alarms.windows(2) {
        check_against_stream(observed, &pair[0], Some(pair[1].tick), report);
    }
    if let Some(last) = observed.alarms.last() {
        check_against_stream(observed, last, None, report);
    }
}

/// Checks the stream from this message of alarms to the next one: it has the same numbers.
fn check_against_stream(observed: &Observed, message: &MachineAlarms, until: Option<u64>, report: &mut ClauseReport) {
    let numbers = alarm_numbers(message);
    let during = |tick: u64| tick >= message.tick && until.is_none_or(|until| tick < until);
    // A tick is repeated to acknowledge a command, then with the changes of the next tick.
    for news in observed.streams.iter().filter(|news| news.tick > message.tick && during(news.tick)) {
        let others = sorted(news.alarms.clone());
        if others != numbers {
            let tick = news.tick;
            return report.broken(
                30,
                format!("tick {tick}: machine/stream has the alarms {others:?}, machine/alarms {numbers:?}"),
            );
        }
    }
}
