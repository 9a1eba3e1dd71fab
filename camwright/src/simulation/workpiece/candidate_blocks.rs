//! Which blocks of azimuths may be inside the wheel.

/// An edge of a block of azimuths.
#[derive(Debug, Clone, Copy)]
pub(super) enum BlockEdge {
    First,
    Last,
}

/// Blocks about the one that the wheel's centre faces: that one, then upwards as far as a part of the largest radius could have them
/// inside the wheel, then downwards.
pub(super) struct CandidateBlocks {
    first: usize,
    seen: usize,
    way: SearchDirection,
}

#[derive(Debug, Clone, Copy)]
enum SearchDirection {
    Here,
    /// The block that was looked at last.
    Up(usize),
    Down(usize),
}

impl CandidateBlocks {
    pub(super) fn new(first: usize) -> Self {
        Self { first, seen: 0, way: SearchDirection::Here }
    }

    /// Returns the next block that may be inside the wheel. `look` returns for a block, by its edge nearest to the wheel's centre,
    /// whether any block could reach there, and whether this block does.
    pub(super) fn next(&mut self, blocks: usize, look: impl Fn(usize, BlockEdge) -> (bool, bool)) -> Option<usize> {
        loop {
            if self.seen == blocks {
                return None;
            }
            // Upwards the near edge of a block is its first azimuth, downwards its last.
            let (block, edge) = match self.way {
                SearchDirection::Here => {
                    self.way = SearchDirection::Up(self.first);
                    self.seen = 1;
                    return Some(self.first);
                }
                SearchDirection::Up(last) => (if last + 1 == blocks { 0 } else { last + 1 }, BlockEdge::First),
                SearchDirection::Down(last) => (if last == 0 { blocks - 1 } else { last - 1 }, BlockEdge::Last),
            };
            let (can, does) = look(block, edge);
            self.way = match (can, self.way) {
                (true, SearchDirection::Down(_)) => SearchDirection::Down(block),
                (true, _) => SearchDirection::Up(block),
                (false, SearchDirection::Down(_)) => return None,
                (false, _) => SearchDirection::Down(self.first),
            };
            if can {
                self.seen += 1;
            }
            if can && does {
                return Some(block);
            }
        }
    }
}
