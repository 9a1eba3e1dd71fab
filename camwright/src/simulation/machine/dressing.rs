//! The wheel as it wears, is dressed and is looked after.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{Axis, WHEEL_TOLERANCE_MM};
use crate::machine::wheel_state::mm_from_nm;
use crate::simulation::workpiece::Removal;

/// How near the wheel must stand to the dresser (mm): beyond it, it is somewhere else, not there with a following error.
const AT_DRESSER_MM: f64 = 0.05;

impl Machine {
    /// Brings the wheel to its speed, unless it would turn faster than it may.
    pub(super) fn start_wheel(&mut self) {
        let radius_mm = self.lasting.wheel_radius_mm;
        if let Err(error) = self.description.wheel.check_speed(radius_mm) {
            self.raise(AlarmKind::WheelTooFast, error.speed_rpm, error.most_rpm);
            return;
        }
        self.wheel.order(!self.estop && !self.mains_lost);
        let smallest_mm = self.description.wheel.min_radius_mm;
        if radius_mm < smallest_mm {
            self.raise(AlarmKind::WheelWorn, radius_mm, smallest_mm);
        }
    }

    pub(super) fn expect_wheel(&mut self, radius_nm: i64) {
        let (wanted_mm, mounted_mm) = (mm_from_nm(radius_nm), self.lasting.wheel_radius_mm);
        if (wanted_mm - mounted_mm).abs() > WHEEL_TOLERANCE_MM {
            self.raise(AlarmKind::OtherWheel, mounted_mm, wanted_mm);
        }
    }

    /// The dresser's rim is where the wheel ends afterwards. With the wheel's cutting point held there the slide follows
    /// the radius by itself, so nothing moves in the machine's coordinates.
    pub(super) fn dress(&mut self, radius_nm: i64) {
        let wheel = self.description.wheel;
        let radius_mm = mm_from_nm(radius_nm);
        let worn_mm = self.lasting.wheel_radius_mm - self.lasting.wheel_wear_mm;
        // As the axes read: the zero of X may have been corrected.
        let zero_mm = |axis: Axis| {
            let axis = &self.axes[axis.index()];
            axis.zero() as f64 / axis.counts_per_unit
        };
        let position = |axis: Axis| {
            let state = &self.axes[axis.index()];
            state.true_position() / state.counts_per_unit - zero_mm(axis)
        };
        let fits = self.description.dresser.is_some_and(|dresser| {
            let beside_mm = 0.5 * dresser.traverse_mm(wheel.width_mm) + AT_DRESSER_MM;
            self.wheel.is_running()
                && (position(Axis::X) - dresser.x_mm).abs() <= AT_DRESSER_MM
                && (position(Axis::Z) - dresser.z_mm).abs() <= beside_mm
                // A slip of the decimal point must not cost a wheel; half a nanometre is the rounding of the order.
                && self.lasting.wheel_radius_mm - radius_mm <= dresser.max_depth_mm + 0.5e-6
        });
        if !fits || radius_mm >= worn_mm || radius_mm < wheel.min_radius_mm || wheel.check_speed(radius_mm).is_err() {
            self.raise(AlarmKind::NotDressed, radius_mm, worn_mm);
            return;
        }
        self.lasting = self.lasting.dressed(radius_mm);
        self.dressed_zero_mm = zero_mm(Axis::X);
        self.ground = None;
    }

    /// What a tick of grinding takes off the wheel, and whether another lobe has begun with it.
    pub(super) fn wear_wheel(&mut self, lobe: usize, removal: Removal) {
        if removal.area_mm2 <= 0.0 {
            return;
        }
        let worn_mm = self.lasting.wheel_radius_mm - self.lasting.wheel_wear_mm;
        self.lasting.wheel_wear_mm += self.description.wheel.wear_mm(worn_mm, removal.area_mm2);
        if self.ground != Some(lobe) {
            self.ground = Some(lobe);
            self.lasting.lobes_since_dress = self.lasting.lobes_since_dress.saturating_add(1);
        }
    }
}
