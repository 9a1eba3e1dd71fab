// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M11, M12 and M31: setpoints that do not come, and those that come with some missing.

use super::super::report::ClauseReport;
use super::ClauseBench;
use super::drive::{Drive, stops};
use super::test_motion::{EarlyEnd, PATIENCE};

/// The sender falls silent in the middle of a travel.
pub(super) fn silence(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    if !bench.is_realtime {
        report.not_seen(12, "at pace fast the machine waits for setpoints");
        report.not_seen(31, "at pace fast the machine waits for setpoints");
        return Ok(());
    }
    let hand = bench.hand;
    let mut drive = Drive::begin(hand, bench.travel(), None)?;
    drive.on(drive.travel.ticks / 2)?;
    let last = drive.tick(drive.sent);
    let begin = hand.ears.read(|observed| observed.streams.len());
    let is_reported = hand.wait(|news| news.alarms.contains(&80) || news.tick > last + drive.travel.ticks);
    let answer = hand.ask_reset()?;
    if is_reported && hand.news().alarms.contains(&80) {
        let raised = hand.ears.read(|observed| {
            observed
                .streams
                .get(begin..)
                .unwrap_or_default()
                .iter()
                .find(|message| message.alarms.contains(&80))
                .map(|message| message.tick)
        });
        let after = raised.unwrap_or(last).saturating_sub(last);
        report.kept(12, format!("alarm 80 came {after} ticks after the last setpoint"));
    } else {
        report.broken(12, format!("no setpoint came after tick {last}, and no alarm 80 by tick {}", hand.news().tick));
    }
    hand.rest()?;
    match answer.recv_timeout(PATIENCE) {
        Ok(answer) if answer.success && is_reported => {
            report.broken(30, "machine/reset reports success while the axes come to rest");
        }
        Ok(_) => {}
        Err(_) => report.broken(30, format!("machine/reset does not answer within {} s", PATIENCE.as_secs())),
    }
    hand.ears.read(|observed| drive.judge(observed, report));
    let (end, wanted) = (hand.news().setpoint_counts, drive.travel.end());
    if end.get(bench.axis) != wanted.get(bench.axis) {
        report
            .broken(12, format!("after silence setpoints rest at {end:?}, the stop that was sent ends at {wanted:?}"));
    }
    hand.clear()?;
    stays(bench, report);
    Ok(())
}

/// A reset starts nothing.
fn stays(bench: &ClauseBench<'_>, report: &mut ClauseReport) {
    let there = bench.hand.news().setpoint_counts;
    if bench.hand.happens(|news| news.setpoint_counts != there || stops(news)) {
        report.broken(30, format!("after a reset setpoints leave {there:?}"));
    } else {
        report.kept(30, "alarms were cleared by a reset at rest, and nothing moved");
    }
}

/// A chunk that begins later than one tick after what was sent.
pub(super) fn lost(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    let hand = bench.hand;
    let mut drive = Drive::begin(hand, bench.travel(), None)?;
    drive.on(drive.travel.ticks / 2)?;
    let (first, last) = (drive.sent + 4, drive.sent + 6);
    let until = drive.tick(last);
    hand.wait(|news| news.credit_tick >= until || stops(news));
    hand.send(&drive.chunk(first, last))?;
    let is_reported = hand.wait(stops) && hand.news().alarms.contains(&85);
    hand.rest()?;
    let alarms = hand.news().alarms;
    if is_reported || alarms.contains(&85) {
        report.kept(11, "a chunk with three ticks missing before it is alarm 85");
    } else {
        let (at, tick) = (drive.tick(first), drive.tick(drive.sent));
        report.broken(
            11,
            format!("a chunk of tick {at} after setpoints up to tick {tick} is not alarm 85; alarms: {alarms:?}"),
        );
    }
    hand.ears.read(|observed| drive.judge(observed, report));
    hand.clear()
}
