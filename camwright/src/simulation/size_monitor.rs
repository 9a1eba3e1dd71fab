//! The size monitor of the in-process gauge: the mean diameter over the last turn of the part against a size.
//!
//! Gauge amplifiers of cylindrical grinders switch an output at a size. This one averages the diameter over a whole turn of C. The mean
//! does not depend on where the gauge stands in the turn, no even wave of the part moves it, and noise averages out of it; the smallest
//! diameter would be reached too early by noise and by every flat. At a feed f per turn of the radius the mean lags the reading by f in
//! the diameter, which is the same on every part.
//!
//! ```text
//!  mean = (71 whole sectors + what has passed of the present one + what remains of the oldest)/72
//!         |--- a turn ---------------------------------|
//!  ... |oldest|  2  |  3  | ...                  | present
//! ```
//! Its output closes once and stays closed until it watches anew.

use crate::machine::wheel_state::mm_from_nm;
use crate::math::units::TURN_RAD;

/// Sectors of a turn: the 5° steps of the published measurement.
const SECTORS: u32 = 72;

/// Watches the mean diameter over the last whole turn of C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeMonitor {
    /// Diameter that closes the output (nm); 0: it does not watch.
    diameter_nm: i64,
    /// Sum of the diameter over C in each sector when it was last passed (mm·sectors).
    passed_mm: [f64; SECTORS as usize],
    /// Sectors passed forwards without a break, at most a turn and one. The first of them may have been entered in its middle.
    passed: u32,
    /// C (sectors) and diameter of the last reading (mm); none before the first.
    last: Option<[f64; 2]>,
    /// Sum over the present sector, from its beginning or from the first reading on (mm·sectors).
    present_mm: f64,
    is_closed: bool,
}

crate::snapshot!(SizeMonitor { diameter_nm, passed_mm, passed, last, present_mm, is_closed } on {});

impl Default for SizeMonitor {
    fn default() -> Self {
        Self {
            diameter_nm: 0,
            passed_mm: [0.0; SECTORS as usize],
            passed: 0,
            last: None,
            present_mm: 0.0,
            is_closed: false,
        }
    }
}

impl SizeMonitor {
    /// Watches anew, from the present on: its output is open until a whole turn has been read.
    pub fn watch(&mut self, diameter_nm: i64) {
        *self = Self { diameter_nm: diameter_nm.max(0), ..Self::default() };
    }

    #[must_use]
    pub const fn is_watching(&self) -> bool {
        self.diameter_nm > 0
    }

    /// Returns whether the size has been read since it watches.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Ends a tick with C there (rad, counted on over turns) and this diameter (mm); `None`: the gauge reads nothing. True in the tick in
    /// which the output closes.
    pub fn tick(&mut self, c_rad: f64, diameter_mm: Option<f64>) -> bool {
        if !self.is_watching() || self.is_closed {
            return false;
        }
        let Some(diameter_mm) = diameter_mm.filter(|mm| mm.is_finite()) else {
            self.begin_again(None);
            return false;
        };
        let at = c_rad / TURN_RAD * f64::from(SECTORS);
        match self.last.replace([at, diameter_mm]) {
            // A part that turns forwards, by less than a turn in a tick.
            Some([from, from_mm]) if at > from && at - from < f64::from(SECTORS) => self.add(from, from_mm, at, diameter_mm),
            Some([from, _]) if at.to_bits() == from.to_bits() => {}
            _ => self.begin_again(Some([at, diameter_mm])),
        }
        self.is_closed = self.mean_mm().is_some_and(|mean_mm| mean_mm <= mm_from_nm(self.diameter_nm));
        self.is_closed
    }

    /// Mean diameter over the last turn (mm); `None` before a whole turn has been read.
    #[must_use]
    pub fn mean_mm(&self) -> Option<f64> {
        let [at, _] = self.last?;
        if self.passed <= SECTORS {
            return None;
        }
        let sector = libm::floor(at);
        let oldest_mm = self.passed_mm[place(sector)];
        let whole_mm: f64 = self.passed_mm.iter().sum();
        // What has passed of the present sector takes the place of as much of the oldest.
        Some((whole_mm - oldest_mm * (at - sector) + self.present_mm) / f64::from(SECTORS))
    }

    /// Discards what has been read.
    fn begin_again(&mut self, last: Option<[f64; 2]>) {
        (self.passed, self.present_mm, self.last) = (0, 0.0, last);
    }

    /// Adds the trapezoid between two readings, sector by sector.
    fn add(&mut self, from: f64, from_mm: f64, to: f64, to_mm: f64) {
        let slope = (to_mm - from_mm) / (to - from);
        let at_mm = |place: f64| from_mm + slope * (place - from);
        let mut begin = from;
        loop {
            let sector_end = libm::floor(begin) + 1.0;
            let end = to.min(sector_end);
            self.present_mm += (end - begin) * 0.5 * (at_mm(begin) + at_mm(end));
            if sector_end > to {
                return;
            }
            self.passed_mm[place(sector_end - 1.0)] = self.present_mm;
            self.passed = (self.passed + 1).min(SECTORS + 1);
            self.present_mm = 0.0;
            begin = sector_end;
            if begin >= to {
                return;
            }
        }
    }
}

#[allow(clippy::cast_possible_truncation, reason = "turns of a job, then below the number of sectors")]
fn place(sector: f64) -> usize {
    (sector as i64).rem_euclid(i64::from(SECTORS)) as usize
}
