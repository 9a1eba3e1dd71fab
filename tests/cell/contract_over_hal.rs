// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine contract of a machine behind HAL.

use crate::hal::{Hal, NAMESPACE};
use crate::support;
use camwright_machine_check::{ClauseVerdict, Moving, Settings, check};
use camwright_ros::{RosArgs, Shutdown};
use std::time::Duration;
use support::{Domain, PATIENCE};

/// The check of the machine contract: C turns out of its origin detector, so that an edge and a closed input are seen.
#[test]
fn a_machine_behind_hal_keeps_its_contract() {
    const SEEN: [u8; 21] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16, 20, 21, 30, 31, 33, 40];
    // A virtual computer pauses for longer than the queue lasts.
    for attempt in 1.. {
        let Some(hal) = Hal::start(Some("0.001")) else { return };
        let domain = Domain::reserve();
        let mut machine = hal.node(&domain);
        let args = RosArgs::default().with_domain_id(domain.id()).with_namespace(NAMESPACE);
        let moving = Some(Moving { joint: "c_axis".into(), distance: 0.5 });
        let settings = Settings { listen: Duration::from_secs(2), patience: PATIENCE, moving };
        let checked = check(&args, &settings, &Shutdown::new(), &|_| {}).expect("a machine that is free");
        machine.interrupt();
        assert!(machine.wait(PATIENCE).success(), "{}", machine.stderr());
        let report = checked.report;
        let (kept, broken) = (report.clauses(ClauseVerdict::Kept), report.clauses(ClauseVerdict::Broken));
        if attempt < 3 && !broken.is_empty() {
            eprintln!("once more, after:\n{report}\n{}", machine.stderr());
            continue;
        }
        assert_eq!((kept, broken), (SEEN.to_vec(), Vec::new()), "{report}\n{}", machine.stderr());
        return;
    }
}
