//! Power of the drives, and the reset after an alarm.

use super::{Machine, Mode, ResetRefused};
use crate::machine::alarm::Severity;
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::math::fixed_list::FixedList;

impl Machine {
    /// Clears the alarms whose causes are gone and gives the drives their power again. The axes hold where they are;
    /// nothing that was under way is resumed.
    ///
    /// # Errors
    /// Emergency stop pressed, mains lost, a drive fault that persists, axes that are not at rest yet, a wheel that has still
    /// to leave the part or turns behind an open door; nothing has changed then.
    pub fn reset(&mut self) -> Result<(), ResetRefused> {
        if self.estop {
            return Err(ResetRefused::EStopPressed);
        }
        if self.mains_lost {
            return Err(ResetRefused::PowerLost);
        }
        if self.work_area.is_some_and(|area| area.entered()) {
            return Err(ResetRefused::Entered);
        }
        if let Some(hindrance) = self.hindrance().filter(|_| self.wheel_turns()) {
            return Err(ResetRefused::WheelTurns(hindrance));
        }
        for axis in Axis::ALL {
            if self.drive_faults[axis.index()] {
                return Err(ResetRefused::DriveFault(axis));
            }
            if !self.axes[axis.index()].is_at_rest() {
                return Err(ResetRefused::Moving(axis));
            }
        }
        let stops = self.alarms.iter().any(|alarm| alarm.kind.entry().severity > Severity::Warning);
        if stops && self.powered && self.mode != Mode::Halted {
            return Err(ResetRefused::Moving(Axis::X));
        }
        self.alarms = FixedList::new();
        self.power_off_due = false;
        self.powered = self.drives_ordered;
        self.dead = [!self.powered; AXIS_COUNT];
        self.draw = None;
        self.followed = self.setpoint();
        self.mode = Mode::Following;
        Ok(())
    }

    /// Orders power for the drives, or none: then the axes brake. Power comes only when no alarm keeps it away.
    pub fn set_drives(&mut self, on: bool) {
        self.drives_ordered = on;
        let kept_off = self.alarms.iter().any(|alarm| alarm.kind.entry().severity == Severity::PowerOff);
        if !on {
            self.power_off_due = true;
            self.react();
        } else if !kept_off && self.is_at_rest() {
            self.powered = true;
            self.dead = [false; AXIS_COUNT];
            self.followed = self.setpoint();
            if self.alarms.iter().all(|alarm| alarm.kind.entry().severity == Severity::Warning) {
                self.mode = Mode::Following;
            }
        }
    }
}
