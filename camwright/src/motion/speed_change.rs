// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Change of the speed of C between two cuts, while C keeps turning.

use crate::machine::description::MotionLimits;
use crate::motion::point_to_point::{JerkLaw, velocity_change};

/// Share of C's acceleration and jerk limits that a change of speed between two cuts uses. The rest is reserved for a stop meanwhile.
pub(crate) const SPEED_CHANGE_SHARE: f64 = 0.5;

/// Returns the angle of C over time (rad over s) from the end of one cut on: from the speed there to the speed of the next cut, which
/// it then keeps.
pub(crate) fn change_of_speed(from_rad_s: f64, to_rad_s: f64, c: &MotionLimits) -> JerkLaw {
    velocity_change(from_rad_s, to_rad_s, &c.with_share(SPEED_CHANGE_SHARE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::description::Axis;
    use crate::machine::reference::cam_grinder;

    /// A change of speed keeps its share of the limits and ends at the speed wanted, to the bit.
    #[test]
    fn a_change_of_speed_ends_at_the_speed_of_the_next_cut() {
        let machine = cam_grinder();
        let c = machine.axis(Axis::C).limits;
        for (from, to) in [(6.0, 6.0), (6.0, 2.0), (1.0, 20.0)] {
            let law = change_of_speed(from, to, &c);
            assert_eq!(law.sample(law.duration() + 1.0).first.to_bits(), f64::to_bits(to));
            assert!(law.peaks().1 <= SPEED_CHANGE_SHARE * c.acceleration * (1.0 + 1e-9));
        }
    }
}
