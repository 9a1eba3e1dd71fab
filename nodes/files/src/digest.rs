// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Digests of 64 bits: of outputs, to compare runs, and of messages, to detect a changed one. They detect accidents, not intent.

use camwright_msgs::cdr::sample_from_message;
use serde::Serialize;

/// A digest of words in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0x6a09_e667_f3bc_c909)
    }
}

impl Digest {
    /// Takes a word in. For a given word every digest becomes another, and for a given digest every word another: two streams that
    /// differ in one word differ from there on, unless a later difference undoes it.
    pub fn word(&mut self, word: u64) {
        let mixed = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = (mixed ^ (mixed >> 32)).wrapping_add(1);
    }

    /// Takes a number in, by its bits.
    pub fn number(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    pub fn octets(&mut self, octets: &[u8]) {
        for eight in octets.chunks(8) {
            let mut word = [0; 8];
            word[..eight.len()].copy_from_slice(eight);
            self.word(u64::from_le_bytes(word));
        }
        self.word(octets.len() as u64);
    }

    /// The digest that goes on from this value.
    #[must_use]
    pub const fn from_value(value: u64) -> Self {
        Self(value)
    }

    /// The digest of all that was taken in.
    #[must_use]
    pub const fn value(self) -> u64 {
        self.0
    }
}

/// The digest of a message as it travels.
///
/// # Errors
/// A message that CDR cannot carry.
pub fn message_digest<M: Serialize>(message: &M) -> Result<u64, String> {
    let mut digest = Digest::default();
    digest.octets(&sample_from_message(message)?);
    Ok(digest.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_every_word_counts() {
        let digest = |words: &[u64]| {
            let mut digest = Digest::default();
            words.iter().for_each(|word| digest.word(*word));
            digest.value()
        };
        let words = [0, 1, u64::MAX, 0x1234_5678_9abc_def0];
        let reference = digest(&words);
        for place in 0..words.len() {
            for bit in 0..64 {
                let mut changed = words;
                changed[place] ^= 1 << bit;
                assert_ne!(digest(&changed), reference, "bit {bit} of word {place}");
            }
        }
        assert_ne!(digest(&words[..3]), reference);
        assert_ne!(digest(&[1, 0]), digest(&[0, 1]));
    }
}
