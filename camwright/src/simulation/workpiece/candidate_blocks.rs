// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which blocks of azimuths may be inside the wheel.
//!
//! A wheel whose centre moves by less than a margin stays inside the wheel that is larger by it. So [`BlockList`] searches once with the
//! larger wheel; every position within the margin then looks at the listed blocks alone: at the one point of each that is the nearest to the
//! wheel's centre if the block is as high as its highest azimuth. It finds every block that a search of its own would find.

/// An edge of a block of azimuths.
#[derive(Debug, Clone, Copy)]
pub(super) enum BlockEdge {
    First,
    Last,
}

/// Capacity of a list; with more blocks every position searches by itself.
const MAX_LISTED: usize = 64;

/// Index of the first block that is found upwards.
const MIDDLE: usize = MAX_LISTED / 2;

/// Fewest blocks of a turn for a list: no block may reach half around the part.
const MIN_BLOCKS: usize = 16;

/// Addition to the square of the wheel's radius for rounding, as a share.
const ROUNDING: f64 = 1e-12;

/// Centre of the wheel in the frame of the part (mm), and its radius (mm).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WheelDisc {
    pub(super) centre: (f64, f64),
    pub(super) radius_mm: f64,
}

/// A block that is found, and its nearest point in the frame of the part (mm).
#[derive(Debug, Clone, Copy)]
pub(super) struct FoundBlock {
    pub(super) block: usize,
    pub(super) point: (f64, f64),
}

/// Blocks that the wheel can meet while it stays within a margin of a disc.
#[derive(Debug, Clone)]
pub(super) struct BlockList {
    disc: WheelDisc,
    /// Below 0: there is no list.
    margin_mm: f64,
    /// The block about which they were found.
    first: usize,
    /// Blocks of a turn.
    turn: usize,
    /// Distances from the first block, rising.
    offsets: [i32; MAX_LISTED],
    points: [[f64; MAX_LISTED]; 2],
    /// Range of the indices in use.
    begin: usize,
    end: usize,
}

impl BlockList {
    pub(super) const fn new() -> Self {
        Self {
            disc: WheelDisc { centre: (0.0, 0.0), radius_mm: 0.0 },
            margin_mm: -1.0,
            first: 0,
            turn: 0,
            offsets: [0; MAX_LISTED],
            points: [[0.0; MAX_LISTED]; 2],
            begin: MIDDLE,
            end: MIDDLE,
        }
    }

    pub(super) fn clear(&mut self) {
        self.margin_mm = -1.0;
    }

    /// Lists the blocks that `next` finds about the block `first` of a turn of so many, for the wheel with the margin added. There is no list
    /// of too many, nor on a part of few blocks.
    pub(super) fn collect(
        &mut self,
        disc: WheelDisc,
        margin_mm: f64,
        (first, turn): (usize, usize),
        mut next: impl FnMut() -> Option<FoundBlock>,
    ) {
        (self.disc, self.margin_mm, self.first, self.turn) = (disc, -1.0, first, turn);
        (self.begin, self.end) = (MIDDLE, MIDDLE);
        if turn < MIN_BLOCKS {
            return;
        }
        while let Some(FoundBlock { block, point }) = next() {
            let offset = self.offset(block);
            let at = if offset >= 0 {
                self.end += 1;
                self.end - 1
            } else {
                self.begin = self.begin.wrapping_sub(1);
                self.begin
            };
            if at >= MAX_LISTED {
                return;
            }
            self.offsets[at] = offset;
            (self.points[0][at], self.points[1][at]) = point;
        }
        self.margin_mm = margin_mm;
    }

    /// Distance of a block from the first, the shorter way round.
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "no turn has so many blocks")]
    fn offset(&self, block: usize) -> i32 {
        let upwards = if block >= self.first { block - self.first } else { block + self.turn - self.first };
        if 2 * upwards <= self.turn { upwards as i32 } else { upwards as i32 - self.turn as i32 }
    }

    /// The block at an index of the list.
    fn block(&self, index: usize) -> usize {
        let offset = self.offsets[index];
        let steps = offset.unsigned_abs() as usize;
        let block = if offset < 0 { self.first + self.turn - steps } else { self.first + steps };
        if block >= self.turn { block - self.turn } else { block }
    }

    /// Returns whether the wheel is so near to where the blocks were collected that no other can be inside it, nor inside one that is larger
    /// by `more_mm`.
    pub(super) fn holds(&self, disc: &WheelDisc, more_mm: f64) -> bool {
        let (dx, dy) = (disc.centre.0 - self.disc.centre.0, disc.centre.1 - self.disc.centre.1);
        let left_mm = self.margin_mm - more_mm - (disc.radius_mm - self.disc.radius_mm);
        left_mm >= 0.0 && dx * dx + dy * dy <= left_mm * left_mm
    }

    /// The listed blocks that may be inside the wheel, whose centre faces the block `first`.
    fn candidates(&self, disc: &WheelDisc, first: usize) -> ListedBlocks {
        let (x, y) = disc.centre;
        let square = disc.radius_mm * disc.radius_mm * (1.0 + ROUNDING);
        let range = self.begin..self.end;
        let mut inside = 0_u64;
        for ((index, px), py) in range.clone().zip(&self.points[0][range.clone()]).zip(&self.points[1][range.clone()]) {
            let (dx, dy) = (px - x, py - y);
            inside |= u64::from(dx * dx + dy * dy < square) << index;
        }
        // From the block that the centre faced to the one that it faces, another point is nearest: they are looked at in any case.
        let facing = self.offset(first);
        let (from, to) = (facing.min(0), facing.max(0));
        let mut index = MIDDLE;
        while index > self.begin && self.offsets[index - 1] >= from {
            index -= 1;
        }
        let mut at = index;
        while index < self.end && self.offsets[index] <= to {
            inside |= 1 << index;
            index += 1;
            if self.offsets[index - 1] < facing {
                at = index;
            }
        }
        let below = if at < MAX_LISTED { (1 << at) - 1 } else { u64::MAX };
        ListedBlocks { up: inside & !below, down: inside & below }
    }
}

/// Indices of listed blocks that may be inside the wheel: from where its centre is upwards, then downwards.
#[derive(Debug, Clone, Copy)]
struct ListedBlocks {
    up: u64,
    down: u64,
}

impl ListedBlocks {
    fn next(&mut self) -> Option<usize> {
        if self.up != 0 {
            let index = self.up.trailing_zeros();
            self.up &= self.up - 1;
            return Some(index as usize);
        }
        let index = self.down.checked_ilog2()?;
        self.down ^= 1 << index;
        Some(index as usize)
    }
}

/// Blocks about the one that the wheel's centre faces: that one, then upwards as far as a part of the largest radius could have them
/// inside the wheel, then downwards.
pub(super) struct CandidateBlocks<'a> {
    search: Search<'a>,
}

enum Search<'a> {
    All { first: usize, seen: usize, way: SearchDirection },
    Listed(&'a BlockList, ListedBlocks),
}

#[derive(Debug, Clone, Copy)]
enum SearchDirection {
    Here,
    /// The block that was looked at last.
    Up(usize),
    Down(usize),
}

impl<'a> CandidateBlocks<'a> {
    /// Searches everywhere.
    pub(super) fn of_all(first: usize) -> Self {
        Self { search: Search::All { first, seen: 0, way: SearchDirection::Here } }
    }

    /// Searches in a list if it holds for the wheel.
    pub(super) fn new(first: usize, disc: &WheelDisc, list: Option<&'a BlockList>) -> Self {
        match list.filter(|list| list.holds(disc, 0.0)) {
            Some(list) => Self { search: Search::Listed(list, list.candidates(disc, first)) },
            None => Self::of_all(first),
        }
    }

    /// Returns the next block that may be inside the wheel. `look` returns for a block, by its edge nearest to the wheel's centre,
    /// whether any block could reach there, and whether this block does.
    pub(super) fn next(&mut self, blocks: usize, look: impl Fn(usize, BlockEdge) -> (bool, bool)) -> Option<usize> {
        self.next_with_edge(blocks, look).map(|(block, _)| block)
    }

    /// The same with the edge that was looked at; of no meaning for a listed block and for the first.
    pub(super) fn next_with_edge(
        &mut self,
        blocks: usize,
        look: impl Fn(usize, BlockEdge) -> (bool, bool),
    ) -> Option<(usize, BlockEdge)> {
        let (first, seen, way) = match &mut self.search {
            Search::Listed(list, listed) => return listed.next().map(|index| (list.block(index), BlockEdge::First)),
            Search::All { first, seen, way } => (*first, seen, way),
        };
        loop {
            if *seen == blocks {
                return None;
            }
            // Upwards the near edge of a block is its first azimuth, downwards its last.
            let (block, edge) = match *way {
                SearchDirection::Here => {
                    *way = SearchDirection::Up(first);
                    *seen = 1;
                    return Some((first, BlockEdge::First));
                }
                SearchDirection::Up(last) => (if last + 1 == blocks { 0 } else { last + 1 }, BlockEdge::First),
                SearchDirection::Down(last) => (if last == 0 { blocks - 1 } else { last - 1 }, BlockEdge::Last),
            };
            let (can, does) = look(block, edge);
            *way = match (can, *way) {
                (true, SearchDirection::Down(_)) => SearchDirection::Down(block),
                (true, _) => SearchDirection::Up(block),
                (false, SearchDirection::Down(_)) => return None,
                (false, _) => SearchDirection::Down(first),
            };
            if can {
                *seen += 1;
            }
            if can && does {
                return Some((block, edge));
            }
        }
    }
}
