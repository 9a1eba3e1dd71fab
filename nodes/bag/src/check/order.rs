//! The order of log times over the whole bag.

use mcap::records::MessageHeader;

use super::report::{Report, Tally};

/// What is wrong with log times, with the first message that shows it.
#[derive(Default)]
pub(super) struct Order {
    last_ns: Option<u64>,
    at_zero: Tally,
    equal: Tally,
    back: Tally,
}

impl Order {
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

    pub(super) fn tell(&self, report: &mut Report) {
        const PLACE: &str = "messages";
        if let Some(text) = self.at_zero.tell("with the log time 0, which viewers refuse") {
            report.error(PLACE, text);
        }
        if let Some(text) = self.equal.tell("with the log time of the one before, which players may reorder") {
            report.warning(PLACE, text);
        }
        if let Some(text) = self.back.tell("with a log time before that of the one before") {
            report.warning(PLACE, text);
        }
    }
}
