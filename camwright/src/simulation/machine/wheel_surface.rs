//! Where the wheel's surface is when its slide stands somewhere: growth, wear, unbalance.

use super::Machine;
use crate::math::units::TURN_RAD;

/// Largest angle between two positions of a wheel with unbalance (rad): thirteen of them make a wave.
const WAVE_STEP_RAD: f64 = 0.5;

/// The wheel during one servo step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    /// Its radius (mm).
    pub(super) radius_mm: f64,
    /// Its centre from where X is counted, without unbalance (mm).
    pub(super) centre_mm: f64,
    unbalance_mm: f64,
    /// Its phase at the beginning, and by how much it turns (rad).
    phase_rad: f64,
    turn_rad: f64,
}

impl Surface {
    /// How much farther its centre is from the part at fraction `s` of the step (mm).
    pub(super) fn thrown_mm(&self, s: f64) -> f64 {
        if self.unbalance_mm == 0.0 { 0.0 } else { self.unbalance_mm * libm::cos(self.phase_rad + s * self.turn_rad) }
    }

    /// Most of it, either way (mm).
    pub(super) fn most_thrown_mm(&self) -> f64 {
        self.unbalance_mm
    }

    /// Positions in which the step must be swept for its wave.
    pub(super) fn positions(&self) -> f64 {
        if self.unbalance_mm == 0.0 { 1.0 } else { libm::ceil(self.turn_rad / WAVE_STEP_RAD) }
    }
}

impl Machine {
    /// The axis knows the wheel as it was dressed. What it has lost since then is missing at its rim; what the wheelhead had grown by when
    /// it was dressed was taken off it, and what it has grown by now brings it nearer. Unbalance throws its centre about, once a turn,
    /// as far as the wheel is at speed: at half of it a quarter, as the force goes with the square.
    pub(super) fn surface(&self, servo_step: u32) -> Surface {
        let lasting = &self.lasting;
        let (grown_mm, dressed_mm) = match self.description.thermal {
            Some(_) => (lasting.growth_mm, lasting.growth_at_dress_mm),
            None => (0.0, 0.0),
        };
        let speed_rad_s = self.wheel_rad_s();
        let turn_rad = speed_rad_s * self.step_s;
        let share = self.wheel.share_of_speed();
        Surface {
            // The dresser's rim stands where it stands, whatever the zero of X was corrected by before.
            radius_mm: lasting.wheel_radius_mm - lasting.wheel_wear_mm - dressed_mm + self.dressed_zero_mm,
            centre_mm: lasting.wheel_radius_mm - grown_mm,
            unbalance_mm: self.description.wheel.unbalance_mm * share * share,
            phase_rad: self.wheel_phase_rad + turn_rad * f64::from(servo_step),
            turn_rad,
        }
    }

    /// A tick of the running wheel is over: it has turned on, and warms its head. Its phase is counted from where it began to run up.
    pub(super) fn turn_on(&mut self) {
        let turned_rad = self.wheel_rad_s() * self.description.cycle_time_s();
        if turned_rad == 0.0 {
            self.wheel_phase_rad = 0.0;
            return;
        }
        self.wheel_phase_rad = libm::fmod(self.wheel_phase_rad + turned_rad, TURN_RAD);
        if let Some(thermal) = self.description.thermal {
            // What is left of the way to a warm machine, times 1 − exp(−T/τ).
            self.lasting.growth_mm += (thermal.growth_mm - self.lasting.growth_mm) * self.warming;
        }
    }
}
