// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which of a topic's messages have come, by the numbers that their publishers give them: a gap is a loss on the way here.

use std::collections::BTreeMap;

use camwright_ros::Guid;

/// Result for the number of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TopicArrival {
    /// It follows the last one; so many between the two have not come.
    After(u64),
    /// It was among those that had not come.
    Late,
    /// Nothing: it is older than all that was seen of its publisher.
    Older,
}

/// The numbers seen of each publisher.
#[derive(Debug, Default)]
pub(super) struct Arrivals {
    seen: BTreeMap<Guid, (i64, i64)>,
}

impl Arrivals {
    /// Takes the number of a message, which DDS delivers once.
    pub(super) fn record(&mut self, writer: Guid, number: i64) -> TopicArrival {
        let (first, greatest) = self.seen.entry(writer).or_insert((number, number));
        if number >= *greatest {
            let missing = number.saturating_sub(*greatest).saturating_sub(1);
            *greatest = number;
            TopicArrival::After(u64::try_from(missing).unwrap_or(0))
        } else if number > *first {
            TopicArrival::Late
        } else {
            TopicArrival::Older
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_counted_once_for_each_publisher_and_taken_back_when_it_comes_late() {
        let (a, b) = ([1; 16], [2; 16]);
        let mut arrivals = Arrivals::default();
        let took: Vec<TopicArrival> = [7, 8, 11, 9, 12, 3].map(|number| arrivals.record(a, number)).into();
        let after = TopicArrival::After;
        assert_eq!(took, [after(0), after(0), after(2), TopicArrival::Late, after(0), TopicArrival::Older]);
        assert_eq!([arrivals.record(b, 1), arrivals.record(b, 4)], [after(0), after(2)]);
        assert_eq!(arrivals.record(b, i64::MAX), after(9_223_372_036_854_775_802));
    }
}
