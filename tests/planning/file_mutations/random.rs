// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random numbers that a seed repeats.

/// A splitmix64 generator.
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
    still: bool,
}

impl Random {
    /// The numbers of one case of a campaign.
    pub fn new(seed: u64, case: u64) -> Self {
        let mut random = Self {
            state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ case.wrapping_mul(0xD1B5_4A32_D192_ED03),
            still: false,
        };
        random.next();
        random
    }

    /// The same choices of files and commands, but files stay as they are.
    pub fn still(self) -> Self {
        Self { still: true, ..self }
    }

    /// Returns whether files stay unchanged.
    pub fn is_still(&self) -> bool {
        self.still
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `count`; 0 where that is 0.
    pub fn below(&mut self, count: usize) -> usize {
        if count == 0 { 0 } else { (self.next() % count as u64) as usize }
    }

    /// A number in 0..1.
    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of a list.
    pub fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}
