// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The order of log times over the whole bag.

use mcap::records::MessageHeader;

use super::report::{BagReport, FindingCount};

/// Errors of log times, with the first message that shows each.
#[derive(Default)]
pub(super) struct OrderCheck {
    last_ns: Option<u64>,
    at_zero: FindingCount,
    equal: FindingCount,
    back: FindingCount,
}

impl OrderCheck {
    pub(super) fn message(&mut self, place: &str, topic: &str, header: &MessageHeader) {
        let t = header.log_time;
        let which = || format!("{place}, message {} of {topic} at {t} ns", header.sequence);
        if t == 0 {
            self.at_zero.note(which);
        }
        match self.last_ns {
            Some(last) if t == last => self.equal.note(which),
            Some(last) if t < last => self.back.note(|| format!("{}, {} ns earlier", which(), last - t)),
            _ => {}
        }
        self.last_ns = Some(t);
    }

    pub(super) fn add_to(&self, report: &mut BagReport) {
        const PLACE: &str = "messages";
        if let Some(text) = self.at_zero.sentence("with the log time 0, which viewers refuse") {
            report.error(PLACE, text);
        }
        if let Some(text) = self.equal.sentence("with the log time of the one before, which players may reorder") {
            report.warning(PLACE, text);
        }
        if let Some(text) = self.back.sentence("with a log time before that of the one before") {
            report.warning(PLACE, text);
        }
    }
}
