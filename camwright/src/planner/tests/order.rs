// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The order of the lobes.

use super::*;
use crate::planner::order::fastest_order;

/// The order found is the best of all: in its plan the table moves for the shortest time, and for as much less as it says.
#[test]
fn no_order_of_the_lobes_is_faster_than_the_one_found() {
    let mut job = job();
    for (lobe, station) in job.lobes.iter_mut().zip(["LS5", "LS1", "LS7", "LS3"]) {
        lobe.station = String::from(station);
    }
    let ticks = |order: &[usize]| {
        let mut job = job.clone();
        job.lobes = order.iter().map(|lobe| job.lobes[*lobe].clone()).collect();
        let moves_table = |kind: &SegmentKind| match kind {
            SegmentKind::Move(targets) => targets.iter().any(|target| target.axis == Axis::Z),
            _ => false,
        };
        let segments = planned(&job).plan.segments;
        segments.iter().filter(|segment| moves_table(&segment.kind)).map(|segment| segment.ticks).sum::<u64>()
    };
    let found = fastest_order(&job, &machine());
    let best = ticks(&found.lobes);
    assert_eq!(ticks(&[0, 1, 2, 3]) - best, found.saved_ticks);
    assert!(found.saved_ticks > 500, "{found:?}");
    let mut orders = 0;
    for code in 0..256_usize {
        let order = [code % 4, code / 4 % 4, code / 16 % 4, code / 64];
        if (0..4).all(|lobe| order.contains(&lobe)) {
            assert!(ticks(&order) >= best, "{order:?} is faster than {found:?}");
            orders += 1;
        }
    }
    assert_eq!(orders, 24);
}

#[test]
fn an_order_that_cannot_be_better_is_left_as_it_is() {
    assert_eq!(fastest_order(&job(), &machine()).saved_ticks, 0);
    let mut job = job();
    job.lobes[0].station = String::from("nowhere");
    assert_eq!(fastest_order(&job, &machine()).lobes, [0, 1, 2, 3]);
}
