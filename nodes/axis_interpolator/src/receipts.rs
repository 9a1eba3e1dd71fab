// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Orders on their way to the machine: no setpoint of an order's tick leaves before the machine has said that it has the order.

/// Orders that may be on their way at once.
const CAPACITY: usize = 64;
/// Orders of one tick at most, for which there is always room.
const RESERVE: usize = 16;

/// Orders that the machine has not acknowledged, oldest first.
#[derive(Debug)]
pub(super) struct Receipts {
    /// Number and tick of each.
    orders: Vec<(u32, u64)>,
}

impl Default for Receipts {
    fn default() -> Self {
        Self { orders: Vec::with_capacity(CAPACITY) }
    }
}

impl Receipts {
    pub(super) fn sent(&mut self, sequence: u32, tick: u64) {
        if self.orders.len() == CAPACITY {
            // Never, as the caller stops at `is_full`; the later number stands for both, the earlier tick bounds both.
            let earliest = self.last_tick().saturating_add(1).min(tick);
            self.orders.pop();
            self.orders.push((sequence, earliest));
            return;
        }
        self.orders.push((sequence, tick));
    }

    /// The machine has received the orders up to a number.
    pub(super) fn received(&mut self, sequence: u32) {
        self.orders.retain(|(sent, _)| *sent > sequence);
    }

    pub(super) fn clear(&mut self) {
        self.orders.clear();
    }

    /// Nothing is on its way.
    pub(super) fn is_empty(&self) -> bool {
        self.orders.is_empty()
    }

    /// No more orders may leave now.
    pub(super) fn is_full(&self) -> bool {
        self.orders.len() + RESERVE > CAPACITY
    }

    /// Last tick of which setpoints may leave.
    pub(super) fn last_tick(&self) -> u64 {
        self.orders.iter().map(|(_, tick)| tick.saturating_sub(1)).min().unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earliest_order_bounds_setpoints_until_it_is_received() {
        let mut receipts = Receipts::default();
        assert_eq!(receipts.last_tick(), u64::MAX);
        receipts.sent(6, 300);
        receipts.sent(7, 400);
        receipts.received(5);
        assert_eq!(receipts.last_tick(), 299, "a later order does not let the earlier one go");
        receipts.received(6);
        assert_eq!(receipts.last_tick(), 399);
        receipts.received(7);
        assert!(receipts.is_empty());
    }

    #[test]
    fn there_is_room_for_the_orders_of_a_tick() {
        let mut receipts = Receipts::default();
        let before = receipts.orders.capacity();
        for sequence in 1..=200 {
            receipts.sent(sequence, 1000 + u64::from(sequence));
        }
        assert!(receipts.is_full());
        assert_eq!((receipts.orders.len(), receipts.orders.capacity()), (CAPACITY, before), "nothing is allocated");
        assert_eq!(receipts.last_tick(), 1000);
        receipts.received(200);
        assert!(receipts.is_empty());
    }
}
