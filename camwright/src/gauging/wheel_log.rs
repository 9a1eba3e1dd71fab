// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Logged positions of the wheel while the part turned.

use crate::math::units::deg_from_rad;
use thiserror::Error;

/// Position of the wheel at an angle of the headstock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelPosition {
    /// Angle of the headstock, growing from turn to turn, counted as that of the gauge's readings (rad).
    pub c_rad: f64,
    /// Distance of the cutting point from the part's axis, without deflection: the position of `x_axis` (mm).
    pub x_mm: f64,
}

/// Why positions are no log.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum WheelLogError {
    #[error("no position of the wheel is logged")]
    Empty,
    /// A number that is none.
    #[error("wheel position {index}: angle or position is not a finite number")]
    NotFinite {
        /// Index of the position.
        index: usize,
    },
    /// The part stood, or turned back.
    #[error("wheel position {index}: C at {c_deg:.4} deg is not beyond {previous_deg:.4} deg of the one before")]
    NotIncreasing {
        /// Index of the position.
        index: usize,
        /// Its angle (deg).
        c_deg: f64,
        /// That of the one before (deg).
        previous_deg: f64,
    },
}

/// Positions of the wheel over the angle of the headstock: straight between them, and staying where the last one is.
#[derive(Debug, Clone, Copy)]
pub struct WheelLog<'a> {
    positions: &'a [WheelPosition],
}

impl<'a> WheelLog<'a> {
    /// A log. Dense enough that straight lines do: a position a tick is.
    ///
    /// # Errors
    /// No position, numbers that are none, angles that do not increase.
    pub fn new(positions: &'a [WheelPosition]) -> Result<Self, WheelLogError> {
        if positions.is_empty() {
            return Err(WheelLogError::Empty);
        }
        for (index, position) in positions.iter().enumerate() {
            if !(position.c_rad.is_finite() && position.x_mm.is_finite()) {
                return Err(WheelLogError::NotFinite { index });
            }
            if let Some(before) = index.checked_sub(1)
                && position.c_rad <= positions[before].c_rad
            {
                let (c_deg, previous_deg) = (deg_from_rad(position.c_rad), deg_from_rad(positions[before].c_rad));
                return Err(WheelLogError::NotIncreasing { index, c_deg, previous_deg });
            }
        }
        Ok(Self { positions })
    }

    /// Angle of the first position (rad).
    #[must_use]
    pub fn start_rad(&self) -> f64 {
        self.positions[0].c_rad
    }

    /// The last position: where the wheel stays.
    #[must_use]
    pub fn last(&self) -> WheelPosition {
        self.positions[self.positions.len() - 1]
    }

    /// Position of the wheel at an angle of the headstock (mm); before the first it is the first.
    #[must_use]
    pub fn x_mm(&self, c_rad: f64) -> f64 {
        let right = self.positions.partition_point(|position| position.c_rad <= c_rad);
        let Some(after) = self.positions.get(right) else { return self.last().x_mm };
        let Some(before) = right.checked_sub(1).map(|i| self.positions[i]) else { return after.x_mm };
        before.x_mm + (after.x_mm - before.x_mm) * ((c_rad - before.c_rad) / (after.c_rad - before.c_rad))
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "angles are rounded, and positions are exact by design")]
mod tests {
    use super::*;

    #[test]
    fn the_wheel_is_on_the_line_between_two_positions_and_stays_at_the_last() {
        let positions = [(0.0, 20.0), (1.0, 19.0), (3.0, 19.5)].map(|(c_rad, x_mm)| WheelPosition { c_rad, x_mm });
        let log = WheelLog::new(&positions).unwrap();
        for (c, x) in [(-1.0, 20.0), (0.0, 20.0), (0.25, 19.75), (1.0, 19.0), (2.0, 19.25), (3.0, 19.5), (99.0, 19.5)] {
            assert_eq!(log.x_mm(c), x);
        }
    }

    #[test]
    fn logs_that_are_none_are_refused() {
        let at = |c_rad: f64, x_mm: f64| WheelPosition { c_rad, x_mm };
        assert_eq!(WheelLog::new(&[]).unwrap_err(), WheelLogError::Empty);
        assert_eq!(WheelLog::new(&[at(0.0, f64::NAN)]).unwrap_err(), WheelLogError::NotFinite { index: 0 });
        let standing = [at(0.0, 1.0), at(0.0, 1.0)];
        assert!(matches!(WheelLog::new(&standing).unwrap_err(), WheelLogError::NotIncreasing { index: 1, .. }));
    }
}
