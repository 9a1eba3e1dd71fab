//! Which blocks of azimuths may be inside the wheel.

/// An edge of a block of azimuths.
#[derive(Debug, Clone, Copy)]
pub(super) enum Edge {
    First,
    Last,
}

/// Blocks about the one that the wheel's centre faces: that one, then upwards as far as a part of the largest radius could have them
/// inside the wheel, then downwards.
pub(super) struct Near {
    first: usize,
    seen: usize,
    way: Way,
}

#[derive(Debug, Clone, Copy)]
enum Way {
    Here,
    /// The block that was looked at last.
    Up(usize),
    Down(usize),
}

impl Near {
    pub(super) fn new(first: usize) -> Self {
        Self { first, seen: 0, way: Way::Here }
    }

    /// The next block that may be inside the wheel. `look` tells of a block, by its edge nearest to the wheel's centre, whether any part
    /// could reach there, and whether this block does.
    pub(super) fn next(&mut self, blocks: usize, look: impl Fn(usize, Edge) -> (bool, bool)) -> Option<usize> {
        loop {
            if self.seen == blocks {
                return None;
            }
            // Upwards the near edge of a block is its first azimuth, downwards its last.
            let (block, edge) = match self.way {
                Way::Here => {
                    self.way = Way::Up(self.first);
                    self.seen = 1;
                    return Some(self.first);
                }
                Way::Up(last) => (if last + 1 == blocks { 0 } else { last + 1 }, Edge::First),
                Way::Down(last) => (if last == 0 { blocks - 1 } else { last - 1 }, Edge::Last),
            };
            let (can, does) = look(block, edge);
            self.way = match (can, self.way) {
                (true, Way::Down(_)) => Way::Down(block),
                (true, _) => Way::Up(block),
                (false, Way::Down(_)) => return None,
                (false, _) => Way::Down(self.first),
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
