// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M20 and M21: the order of commands, and inputs that are asked for.

use super::super::report::ClauseReport;
use super::ClauseBench;
use super::drive::Drive;
use super::test_motion::EarlyEnd;
use camwright_msgs::camwright_msgs::msg::{MachineCommand, MachineStream};

/// Checks that the first command of a motion was acknowledged and executed.
pub(super) fn acknowledged(
    bench: &ClauseBench<'_>,
    drive: &Drive<'_>,
    during: &[MachineStream],
    report: &mut ClauseReport,
) {
    let (input, is_closed) = &bench.input;
    report.kept(20, "the first command of a motion was acknowledged with commands_received 1");
    if !is_closed {
        return report.not_seen(21, format!("no input was closed, {input} neither"));
    }
    let answers = during.iter().flat_map(|message| &message.latches).filter(|latch| latch.input == *input);
    let at: Vec<u64> = answers.map(|latch| latch.tick).collect();
    if at.contains(&drive.command_tick) {
        report.kept(21, format!("a latch of tick {} reports {input} as closed, as requested", drive.command_tick));
    } else {
        report.broken(
            21,
            format!(
                "{input} is closed and was requested at tick {}, but no latch reports it; its latches: {at:?}",
                drive.command_tick
            ),
        );
    }
}

/// A command whose number is not the next one.
pub(super) fn gap(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    out_of_order(bench, report, "a command with sequence 3 after 1", 82, |news| (3, news.credit_tick))
}

/// A command whose tick has been executed.
pub(super) fn late(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    out_of_order(bench, report, "a command for an executed tick", 81, |news| (2, news.tick.saturating_sub(2)))
}

fn out_of_order(
    bench: &ClauseBench<'_>,
    report: &mut ClauseReport,
    what: &str,
    number: u16,
    order: impl Fn(&MachineStream) -> (u32, u64),
) -> Result<(), EarlyEnd> {
    let hand = bench.hand;
    let input = &bench.input.0;
    let mut drive = Drive::begin(hand, bench.travel(), Some(input))?;
    drive.on(drive.travel.ticks / 2)?;
    let (sequence, tick) = order(&hand.news());
    hand.order(sequence, tick, MachineCommand::ASK, input)?;
    drive.finish()?;
    // Commands and setpoints are different topics: this one may come after the last setpoint has been executed.
    let is_reported_alarm = |news: &MachineStream| news.alarms.contains(&number);
    let is_reported = is_reported_alarm(&hand.news()) || hand.happens(is_reported_alarm);
    let last = hand.news();
    if is_reported {
        report.kept(20, format!("{what} is alarm {number}"));
    } else {
        report.broken(
            20,
            format!("{what} is not answered by alarm {number}; alarms at tick {}: {:?}", last.tick, last.alarms),
        );
    }
    hand.ears.read(|observed| drive.judge(observed, report));
    hand.clear()
}
