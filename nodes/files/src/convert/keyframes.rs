//! Keyframes as pages of at most 32 kB, and back.

use super::plan::count;
use crate::digest::Digest;
use camwright_msgs::camwright_msgs::msg::MachineKeyframe;

/// Bytes of a state on one page: with everything around them they stay below 32 kB.
pub const BYTES_PER_PAGE: usize = 32_000;

/// The pages of a state; `head` says of which tick.
pub fn pages(head: MachineKeyframe, state: &[u8]) -> impl Iterator<Item = MachineKeyframe> {
    let page_count = count(state.len().div_ceil(BYTES_PER_PAGE));
    let head = MachineKeyframe { page_count, check: check(&head, state), ..head };
    state.chunks(BYTES_PER_PAGE).zip(0..).map(move |(data, page)| MachineKeyframe {
        page,
        data: data.to_vec(),
        ..head.clone()
    })
}

/// The digest by which a keyframe is known to be as it was made, or a state to be that of a keyframe.
#[must_use]
pub fn check(head: &MachineKeyframe, state: &[u8]) -> u64 {
    let mut digest = Digest::default();
    let words = [head.tick, head.sequence, head.job_tick, head.digest, u64::from(head.form)];
    words.into_iter().for_each(|word| digest.word(word));
    digest.octets(state);
    digest.value()
}

/// A keyframe as its pages come.
#[derive(Debug, Clone, Default)]
pub struct Arriving {
    /// The last page, without its data.
    pub head: MachineKeyframe,
    pages: u32,
}

impl Arriving {
    /// Takes a page; the keyframe whose last one it is, when all before it were there.
    pub fn take(&mut self, page: &MachineKeyframe) -> Option<MachineKeyframe> {
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
        let mut arriving = Arriving::default();
        let whole: Vec<bool> = pages.iter().chain(&pages).map(|page| arriving.take(page).is_some()).collect();
        assert_eq!(whole, [false, false, false, true, false, false, false, true]);
        for lost in 0..4 {
            let mut arriving = Arriving::default();
            let rest = pages.iter().filter(|page| page.page != lost);
            assert!(rest.filter_map(|page| arriving.take(page)).next().is_none(), "page {lost}");
        }
        let mut changed = state;
        changed[77_777] ^= 1;
        assert_ne!(check(&pages[0], &changed), pages[0].check);
    }
}
