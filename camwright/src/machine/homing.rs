//! How a slide with an incremental encoder finds its zero, as `LinuxCNC` does.
//!
//! ```text
//!  search + , latch +          ┌────────── switch        search + , latch −       ┌────────── switch
//!   search  ───────────────────►──┐                       search ─────────────────►──┐
//!   back off          ◄──────────-┘                       latch         ◄────────────┘   the edge where it opens
//!   latch            ─────────►  the edge where it closes
//! ```
//! With an index the axis goes on in the direction of the latch to the next mark of its encoder.

use crate::machine::description::{AxisDescription, Scale};
use crate::machine::description_error::DescriptionError;

/// How a slide is homed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homing {
    /// Velocity of the search for the switch (mm/s); its sign says where the switch is; 0: it is not searched for.
    pub search_mm_s: f64,
    /// Velocity with which the edge or mark is caught (mm/s). With the sign of the search: after backing off, where the switch
    /// closes; with the other: where it opens. 0: nothing is caught.
    pub latch_mm_s: f64,
    /// Speed of the move to `home_mm` (mm/s).
    pub final_mm_s: f64,
    /// The zero is taken from the encoder's index and not from the switch.
    pub use_index: bool,
    /// What the axis reads where the edge or mark was caught (mm); `None`: where the machine's own figures put it.
    pub offset_mm: Option<f64>,
    /// Where the axis goes then (mm).
    pub home_mm: f64,
    /// The switch is the hard limit switch: reaching it is no overtravel before the axis is homed.
    pub ignore_limits: bool,
    /// Axes of smaller numbers are homed before.
    pub sequence: u32,
    /// Where the switch closes for an axis that comes in the direction of the search (mm, true); it stays closed beyond.
    pub switch_mm: f64,
    /// Distance of the encoder's index marks (mm), which lie at its multiples.
    pub index_pitch_mm: f64,
}

/// The kinds of homing that there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HomingKind {
    /// Where the axis stands is its zero.
    Immediate,
    /// The next mark of the encoder.
    IndexOnly,
    /// An edge of the switch.
    SwitchOnly,
    /// An edge of the switch, and then the next mark.
    SwitchAndIndex,
}

impl Homing {
    /// What its velocities and its index make of it; `None`: no homing.
    #[must_use]
    pub fn kind(&self) -> Option<HomingKind> {
        let zero = |value: f64| value.abs() < f64::MIN_POSITIVE;
        match (zero(self.search_mm_s), zero(self.latch_mm_s), self.use_index) {
            (true, true, false) => Some(HomingKind::Immediate),
            (true, false, true) => Some(HomingKind::IndexOnly),
            (false, false, false) => Some(HomingKind::SwitchOnly),
            (false, false, true) => Some(HomingKind::SwitchAndIndex),
            _ => None,
        }
    }

    /// The edge is caught where the switch closes, not where it opens.
    #[must_use]
    pub fn latches_closing(&self) -> bool {
        (self.search_mm_s > 0.0) == (self.latch_mm_s > 0.0)
    }

    /// Where the edge of the switch truly lies that is caught (mm).
    #[must_use]
    pub fn edge_mm(&self, hysteresis_mm: f64) -> f64 {
        if self.latches_closing() {
            self.switch_mm
        } else {
            self.switch_mm - libm::copysign(hysteresis_mm, self.search_mm_s)
        }
    }

    /// What the axis reads at the edge or mark that is caught (mm).
    #[must_use]
    pub fn offset_mm(&self, hysteresis_mm: f64) -> f64 {
        self.offset_mm.unwrap_or_else(|| match self.kind() {
            Some(HomingKind::SwitchOnly) => self.edge_mm(hysteresis_mm),
            Some(HomingKind::SwitchAndIndex) => {
                let marks = self.edge_mm(hysteresis_mm) / self.index_pitch_mm;
                let next = if self.latch_mm_s > 0.0 { libm::floor(marks) + 1.0 } else { libm::ceil(marks) - 1.0 };
                next * self.index_pitch_mm
            }
            _ => self.home_mm,
        })
    }

    /// How far behind the edge the axis may have gone when it is looked for the mark (mm): what it takes for the edge to be
    /// known, and to stop.
    fn overshoot_mm(&self, axis: &AxisDescription, delay_s: f64) -> f64 {
        let v = self.latch_mm_s.abs();
        // A tenth of a second for the servo, and the stop with half the acceleration.
        v * (2.0 * delay_s + 0.1) + v * v / axis.limits.acceleration + v * axis.limits.acceleration / axis.limits.jerk
    }

    /// Whether it fits its axis. `delay_s` is the feedback delay.
    pub(super) fn validate(
        &self,
        axis: &AxisDescription,
        hysteresis_mm: f64,
        delay_s: f64,
    ) -> Result<(), DescriptionError> {
        let joint = axis.axis.joint();
        let refuse = |what: &'static str| Err(DescriptionError::Homing { joint, what });
        if !matches!(axis.scale, Scale::Linear { .. }) {
            return refuse("only slides have a home switch; c_axis is homed on its origin detector");
        }
        let numbers = [self.search_mm_s, self.latch_mm_s, self.home_mm, self.switch_mm, self.offset_mm.unwrap_or(0.0)];
        if !numbers.iter().all(|number| number.is_finite()) {
            return refuse("its numbers must be finite");
        }
        let Some(kind) = self.kind() else {
            return refuse(
                "search and latch velocity and use_index must be 0, 0, no (immediate), 0, not 0, yes (index only), not 0, not 0, \
                 no (switch only) or not 0, not 0, yes (switch and index)",
            );
        };
        let fastest = axis.limits.velocity;
        if self.search_mm_s.abs() > fastest || self.latch_mm_s.abs() > fastest {
            return refuse("its velocities are beyond that of the axis");
        }
        if !(self.final_mm_s > 0.0 && self.final_mm_s <= fastest) {
            return refuse("its final velocity must be positive and not beyond that of the axis");
        }
        if axis.soft_limits.is_some_and(|(low, high)| self.home_mm < low || self.home_mm > high) {
            return refuse("its home position is beyond the soft limits");
        }
        if self.use_index && !(self.index_pitch_mm > 0.0 && self.index_pitch_mm.is_finite()) {
            return refuse("an index needs a positive pitch of its marks");
        }
        if kind == HomingKind::IndexOnly && self.offset_mm.is_none() {
            return refuse("index only needs an offset: which mark comes first depends on where the axis stands");
        }
        if matches!(kind, HomingKind::SwitchOnly | HomingKind::SwitchAndIndex)
            && !self.ignore_limits
            && axis.overtravel.is_some_and(|(low, high)| self.switch_mm <= low || self.switch_mm >= high)
        {
            return refuse("its switch lies beyond the hard limit switch; without ignore_limits it is never reached");
        }
        if kind == HomingKind::SwitchAndIndex {
            let ahead_mm = (self.switch_index_mm(hysteresis_mm) - self.edge_mm(hysteresis_mm)).abs();
            let overshoot_mm = self.overshoot_mm(axis, delay_s);
            if ahead_mm < overshoot_mm || self.index_pitch_mm - ahead_mm < overshoot_mm {
                return refuse("its index mark lies too near the edge of the switch to be told from the next one");
            }
        }
        Ok(())
    }

    fn switch_index_mm(&self, hysteresis_mm: f64) -> f64 {
        Self { offset_mm: None, ..*self }.offset_mm(hysteresis_mm)
    }
}
