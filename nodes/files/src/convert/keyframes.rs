// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Keyframes as pages of at most 32 kB, and back.

use super::pages::{BYTES_PER_PAGE, page_count, split};
use crate::digest::Digest;
use camwright_msgs::camwright_msgs::msg::MachineKeyframe;

/// Pages of a state; `head` has its tick.
pub fn pages(head: MachineKeyframe, state: &[u8]) -> impl Iterator<Item = MachineKeyframe> {
    let page_count = page_count(state.len(), BYTES_PER_PAGE);
    let head = MachineKeyframe { page_count, check: check(&head, state), ..head };
    split(state, BYTES_PER_PAGE).map(move |piece| MachineKeyframe {
        page: piece.page,
        data: piece.items.to_vec(),
        ..head.clone()
    })
}

/// Digest of a keyframe and its state.
#[must_use]
pub fn check(head: &MachineKeyframe, state: &[u8]) -> u64 {
    let mut digest = Digest::default();
    let words = [head.tick, head.sequence, head.job_tick, head.digest, u64::from(head.form)];
    words.into_iter().for_each(|word| digest.word(word));
    digest.octets(state);
    digest.value()
}

/// Keyframe whose pages are arriving.
#[derive(Debug, Clone, Default)]
pub struct PartialKeyframe {
    /// The last page, without its data.
    pub head: MachineKeyframe,
    pages: u32,
}

impl PartialKeyframe {
    /// Adds a page; returns the keyframe with its last page, if none before it was missing.
    pub fn add(&mut self, page: &MachineKeyframe) -> Option<MachineKeyframe> {
        let head = MachineKeyframe { data: Vec::new(), ..page.clone() };
        let goes_on = MachineKeyframe { page: 0, ..self.head.clone() } == MachineKeyframe { page: 0, ..head.clone() };
        self.pages = match page.page {
            0 => 1,
            number if goes_on && number == self.pages => number + 1,
            _ => 0,
        };
        self.head = head;
        (self.pages > 0 && self.pages == page.page_count).then(|| self.head.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_from_its_pages_and_a_lost_one_is_seen() {
        let state: Vec<u8> = (0..100_000_u32).map(|i| i.to_le_bytes()[0] ^ i.to_le_bytes()[1]).collect();
        let head = MachineKeyframe { tick: 700, sequence: 5, form: 1, ..MachineKeyframe::default() };
        let pages: Vec<MachineKeyframe> = pages(head, &state).collect();
        assert_eq!(pages.len(), 4);
        assert_eq!(pages.iter().flat_map(|page| page.data.clone()).collect::<Vec<u8>>(), state);
        assert!(pages.iter().all(|page| page.check == check(&pages[0], &state)));
        let mut arriving = PartialKeyframe::default();
        let whole: Vec<bool> = pages.iter().chain(&pages).map(|page| arriving.add(page).is_some()).collect();
        assert_eq!(whole, [false, false, false, true, false, false, false, true]);
        for lost in 0..4 {
            let mut arriving = PartialKeyframe::default();
            let rest = pages.iter().filter(|page| page.page != lost);
            assert!(rest.filter_map(|page| arriving.add(page)).next().is_none(), "page {lost}");
        }
        let mut changed = state;
        changed[77_777] ^= 1;
        assert_ne!(check(&pages[0], &changed), pages[0].check);
    }
}
