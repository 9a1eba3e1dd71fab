// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! M13 and M33: chunks that are refused while nothing moves, and the stop by software.

use super::super::report::ClauseReport;
use super::ClauseBench;
use super::test_motion::EarlyEnd;
use super::travel::{TestTravel, TravelPoint};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;

/// Setpoints of a chunk that is to be refused.
const POINTS: u64 = 4;

/// Each chunk that must be refused, at rest. All but the jump ask for what is there already; the jump is a few µm.
pub(super) fn run(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    let news = bench.hand.news();
    let resting =
        TestTravel::new(bench.hand.facts, bench.axis, &bench.description.axes[bench.axis], &news.setpoint_counts, 0);
    let points: Vec<(u64, TravelPoint)> = (0..POINTS).map(|tick| (tick, resting.point(0))).collect();
    let ahead = |news: &MachineStream| news.tick + (bench.hand.facts.delay * 6 / 10).max(1);
    let chunk =
        |first: u64, points: &[(u64, TravelPoint)]| resting.chunk(bench.hand.facts, bench.hand.epoch_ns, first, points);
    let late = |news: &MachineStream| chunk(news.tick.saturating_sub(1), &points);
    let beyond = |news: &MachineStream| chunk(news.credit_tick + bench.hand.facts.delay, &points);
    let turned = |news: &MachineStream| {
        let mut chunk = chunk(ahead(news), &points);
        chunk.joint_names.reverse();
        chunk
    };
    let between = |news: &MachineStream| {
        let mut chunk = chunk(ahead(news), &points);
        chunk.header.stamp.nanosec ^= 1;
        chunk
    };
    let (jump, hard) = (jumps(bench, &points), brakes(bench, &points));
    refused(bench, report, "a chunk that begins with an executed tick", late)?;
    refused(bench, report, "a chunk beyond the credit", beyond)?;
    refused(bench, report, "a chunk whose joints are in another order", turned)?;
    refused(bench, report, "a chunk whose stamp is 1 ns off a tick", between)?;
    refused(bench, report, "a setpoint with 1.5 times the acceleration of its axis", |news| chunk(ahead(news), &hard))?;
    match jump {
        Some(jump) => refused(bench, report, "a setpoint that jumps", |news| chunk(ahead(news), &jump)),
        None => Ok(()),
    }
}

/// Points that jump by four times what is allowed; none where that is more than the consent to move.
fn jumps(bench: &ClauseBench<'_>, points: &[(u64, TravelPoint)]) -> Option<Vec<(u64, TravelPoint)>> {
    let limits = &bench.description.axes[bench.axis];
    let cycle_s = bench.hand.facts.cycle_s();
    #[allow(clippy::cast_possible_truncation, reason = "the cast saturates, and is then too much")]
    let max =
        (0.6 * limits.max_acceleration * cycle_s * cycle_s * bench.hand.facts.per_unit[bench.axis]).ceil() as i64 + 2;
    let by = max.saturating_mul(4);
    if by > (bench.away - bench.home).abs() {
        return None;
    }
    // Towards where it is allowed to go.
    let here = points.first()?.1.counts[bench.axis];
    let low = bench.home.min(bench.away);
    let by = if here == low { by } else { -by };
    let mut points = points.to_vec();
    points.iter_mut().skip(1).for_each(|(_, point)| point.counts[bench.axis] += by);
    Some(points)
}

fn brakes(bench: &ClauseBench<'_>, points: &[(u64, TravelPoint)]) -> Vec<(u64, TravelPoint)> {
    let mut points = points.to_vec();
    points[1].1.acceleration = 1.5 * bench.description.axes[bench.axis].max_acceleration;
    points
}

/// A chunk is refused as a whole, with alarm 84, and another one while that is active with none.
fn refused(
    bench: &ClauseBench<'_>,
    report: &mut ClauseReport,
    what: &str,
    chunk: impl Fn(&MachineStream) -> JointTrajectory,
) -> Result<(), EarlyEnd> {
    let hand = bench.hand;
    hand.go_on()?;
    let before = report.evidence(13);
    let there = hand.news().setpoint_counts;
    hand.send(&chunk(&hand.fresh_news()))?;
    let is_reported = hand.happens(|news| news.alarms.contains(&84));
    let news = hand.news();
    if !is_reported {
        report.broken(
            13,
            format!("{what} is not refused with alarm 84; alarms at tick {}: {:?}", news.tick, news.alarms),
        );
    } else {
        hand.send(&chunk(&news))?;
        if hand.happens(|news| news.alarms != [84]) {
            report.broken(13, format!("{what} while alarm 84 is active: alarms are {:?}", hand.news().alarms));
        }
    }
    hand.rest()?;
    if hand.news().setpoint_counts != there {
        let now = hand.news().setpoint_counts;
        report.broken(13, format!("{what} moves setpoints from {there:?} to {now:?}"));
    }
    report.kept_unless_broken(13, before, format!("{what} is refused"));
    hand.clear()
}

/// M33: a stop that needs a release and a reset.
pub(super) fn estop(bench: &ClauseBench<'_>, report: &mut ClauseReport) -> Result<(), EarlyEnd> {
    let hand = bench.hand;
    hand.go_on()?;
    let before = report.evidence(33);
    let there = hand.news().setpoint_counts;
    hand.estop(true)?;
    // Whatever comes now, it is released again.
    let is_reported = hand.happens(|news| news.alarms.contains(&1));
    let reset = hand.reset();
    hand.estop(false)?;
    let released = hand.news().tick;
    // It takes effect with the next tick.
    hand.wait(|news| news.tick > released + 2);
    if !is_reported {
        report.broken(
            33,
            format!("machine/estop is pressed, and alarm 1 does not come; alarms: {:?}", hand.news().alarms),
        );
    }
    if reset?.success {
        report.broken(33, "machine/reset reports success while the stop is pressed");
    }
    hand.clear()?;
    if hand.news().setpoint_counts != there {
        report
            .broken(33, format!("setpoints go from {there:?} to {:?} by stop and reset", hand.news().setpoint_counts));
    }
    report.kept_unless_broken(
        33,
        before,
        "alarm 1, no reset while pressed, reset after the release, and nothing moved",
    );
    Ok(())
}
