// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Machine description: axes with their counts and limits, stations, switches, wheel or insert, drives.

use crate::machine::contact_law::ContactLaw;
use crate::machine::description_error::ordered;
pub use crate::machine::description_error::{DescriptionError, MAX_STATIONS};
use crate::machine::fixture::{Dresser, Extent};
use alloc::string::String;
use alloc::vec::Vec;

pub use crate::machine::axes::{AXIS_COUNT, Axis, AxisScale, MotionLimits};
pub use crate::machine::contact::{ContactDescription, ContactMode, StiffnessAt};
pub use crate::machine::drive::{DriveSettings, Structure};
pub use crate::machine::effect::Effect;
pub use crate::machine::gauge::{GaugeDescription, GaugeKind};
pub use crate::machine::homing::{Homing, HomingKind};
pub use crate::machine::insert::{EdgeArc, InsertDescription, InsertRotation, InsertSpindle};
pub use crate::machine::loading::LoadingDescription;
pub use crate::machine::probe::{GapDetector, KeyWayProbe};
pub use crate::machine::process::{GrindingProcess, ReferenceCut};
pub use crate::machine::retract::AlarmRetract;
pub use crate::machine::thermal::ThermalDescription;
pub use crate::machine::wheel::{WHEEL_TOLERANCE_MM, WheelDescription, WheelTooFast};
pub use crate::machine::wheel_changer::{MAX_WHEELS, MagazineWheel, WheelChanger, WheelsNow};
pub use crate::machine::workholding::{SteadyRest, WorkholdingDescription};

/// One axis of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisDescription {
    pub axis: Axis,
    pub scale: AxisScale,
    pub limits: MotionLimits,
    /// Soft limits: smallest and largest setpoint (mm or rad); `None` for an axis that turns without end.
    pub soft_limits: Option<(f64, f64)>,
    /// Hard limit switches (mm); `None` for an axis without. The headstock has none.
    pub overtravel: Option<(f64, f64)>,
    /// Following error at which the drive trips, at full velocity (mm or rad); `LinuxCNC`'s `FERROR`.
    pub max_following_error: f64,
    /// Following error below which it never trips (mm or rad); `LinuxCNC`'s `MIN_FERROR`.
    pub min_following_error: f64,
    /// True for an incremental encoder: its zero is unknown until the axis has been homed.
    pub needs_homing: bool,
    /// Homing of a slide; `None`: the headstock homes on its origin detector, an absolute encoder not at all.
    pub homing: Option<Homing>,
    /// Speed of a reference search (mm/s or rad/s).
    pub search_velocity: f64,
    pub drive: DriveSettings,
    /// The same axis with what is called a good drive, to compare with; `None`: unknown.
    pub good_drive: Option<DriveSettings>,
    /// Moving mass (kg) or inertia (kg m²).
    pub inertia: f64,
    /// Position of the axis at power-up, relative to the machine's true zero (mm or rad). An incremental encoder reads 0 there, and
    /// homing must find the difference; an absolute one reads this position.
    pub power_up_position: f64,
}

/// A place along the table where a lobe can stand in front of the wheel.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Name of the limit switch.
    pub switch: String,
    /// Table position at which the switch closes when approached in the positive direction (mm).
    pub position_mm: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct MachineDescription {
    pub name: String,
    /// SHA-256 of the canonical machine file, 64 hexadecimal digits.
    pub hash: String,
    /// Interpolation period (ns).
    pub cycle_time_ns: u32,
    /// D: a setpoint for tick k uses feedback up to tick k − D (ticks).
    pub feedback_delay_ticks: u32,
    /// Servo steps in one interpolation period, 4 gives 4 kHz at 1 ms.
    pub servo_steps_per_tick: u32,
    /// The axes, in the order of [`Axis::ALL`].
    pub axes: [AxisDescription; AXIS_COUNT],
    /// Stations in the order of the table's positive travel.
    pub stations: Vec<Station>,
    /// Distance over which a dog keeps a station switch closed (mm).
    pub dog_length_mm: f64,
    /// Hysteresis of a limit switch: it opens this much later than it closed (mm).
    pub switch_hysteresis_mm: f64,
    /// Half the window in which the origin detector sees its mark (rad). The index mark at its centre, which is what the
    /// position latch catches, is the machine's C zero: the keyway's centre faces the wheel.
    pub origin_half_window_rad: f64,
    /// The wheel; of a lathe its insert as what a spindle rotates ([`InsertDescription::tool`]).
    pub wheel: WheelDescription,
    /// The insert of a lathe; `None`: a grinder.
    pub insert: Option<InsertDescription>,
    /// Changer with further wheels; `None`: the machine has one wheel.
    pub wheel_changer: Option<WheelChanger>,
    /// Deflection of wheel and part; `None`: rigid.
    pub contact: Option<ContactDescription>,
    /// Supports that hold the part; `None`: unknown, the part is as stiff as `contact` says.
    pub workholding: Option<WorkholdingDescription>,
    /// Thermal growth of the wheelhead; `None`: none.
    pub thermal: Option<ThermalDescription>,
    /// Gauge that measures the lobe in front of the wheel; `None`: no gauge.
    pub gauge: Option<GaugeDescription>,
    /// Detector of the contact between wheel and part; `None`: no detector.
    pub gap_detector: Option<GapDetector>,
    /// Probe for the part's keyway; `None`: no probe.
    pub key_way_probe: Option<KeyWayProbe>,
    /// Loading equipment; `None`: parts appear without loading.
    pub loading: Option<LoadingDescription>,
    /// Process data of grinding; `None`: unknown.
    pub process: Option<GrindingProcess>,
    /// Retraction of the wheel by an alarm.
    pub retract: AlarmRetract,
    /// Dresser; `None`: no dresser.
    pub dresser: Option<Dresser>,
    /// Room of the headstock with its chuck, where the wheel must not go; `None`: unknown.
    pub headstock: Option<Extent>,
    /// Room of the tailstock with its centre.
    pub tailstock: Option<Extent>,
    /// +1: positive C turns the part clockwise seen from +Z; −1: counter-clockwise.
    pub rotation_sense: i8,
}

impl MachineDescription {
    /// Period of the machine's reports: a tenth of the feedback delay (ticks). The interpolator decides by the measurements of these
    /// ticks only.
    #[must_use]
    pub fn stream_period_ticks(&self) -> u64 {
        u64::from(self.feedback_delay_ticks / 10).max(1)
    }

    /// Period of the reports of a machine that stands still at pace realtime without setpoints (ticks).
    #[must_use]
    pub fn rest_stream_period_ticks(&self) -> u64 {
        5 * self.stream_period_ticks()
    }

    /// Returns whether it turns with an insert; otherwise it grinds with a wheel.
    #[must_use]
    pub fn is_lathe(&self) -> bool {
        self.insert.is_some()
    }

    /// Returns whether its tool cuts at rest: a lathe's insert that does not rotate.
    #[must_use]
    pub fn cuts_at_rest(&self) -> bool {
        self.insert.is_some_and(|insert| insert.spindle.is_none())
    }

    /// This lathe with the rake face set to another height (mm).
    ///
    /// # Errors
    /// A height that the tool cannot be set to; a grinder.
    pub fn with_rake_height(mut self, height_mm: f64) -> Result<Self, DescriptionError> {
        let Some(insert) = &mut self.insert else {
            return Err(DescriptionError::NotALathe);
        };
        insert.height_mm = height_mm;
        insert.validate()?;
        Ok(self)
    }

    /// A lathe's rotating tool is its insert, and it has nothing of what only a grinder is simulated with: what is cut does not deflect,
    /// nothing measures it and nothing dresses.
    pub(super) fn validate_insert(&self) -> Result<(), DescriptionError> {
        let Some(insert) = &self.insert else { return Ok(()) };
        insert.validate()?;
        let only = [
            (self.wheel != insert.tool(), "a wheel"),
            (self.contact.is_some(), "a contact"),
            (self.workholding.is_some(), "supports of a part"),
            (self.thermal.is_some(), "a wheelhead that grows"),
            (self.gauge.is_some(), "a gauge"),
            (self.gap_detector.is_some(), "a gap detector"),
            (self.process.is_some(), "a grinding process"),
            (self.dresser.is_some(), "a dresser"),
            (self.wheel_changer.is_some(), "a wheel changer"),
        ];
        match only.into_iter().find(|(has, _)| *has) {
            Some((_, what)) => Err(DescriptionError::OnlyOfAGrinder { what }),
            None => Ok(()),
        }
    }

    /// Interpolation period (s).
    #[must_use]
    pub fn cycle_time_s(&self) -> f64 {
        f64::from(self.cycle_time_ns) * 1e-9
    }

    /// The description of an axis.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> &AxisDescription {
        &self.axes[axis.index()]
    }

    /// The station with this switch.
    #[must_use]
    pub fn station(&self, switch: &str) -> Option<&Station> {
        self.stations.iter().find(|station| station.switch == switch)
    }

    /// Contact law at a station, over a lobe of this width (mm); `None` on a rigid machine.
    #[must_use]
    pub fn contact_law(&self, switch: &str, width_mm: f64) -> Option<ContactLaw> {
        self.contact_law_at(self.station(switch)?.position_mm, width_mm)
    }

    /// Contact law at a position of the table (mm), over a lobe of this width (mm); `None` on a rigid machine.
    #[must_use]
    pub fn contact_law_at(&self, z_mm: f64, width_mm: f64) -> Option<ContactLaw> {
        self.contact.as_ref()?.law(z_mm, width_mm.min(self.wheel.width_mm))
    }

    /// Checks that the values describe a possible machine.
    ///
    /// # Errors
    /// The first figure that does not.
    pub fn validate(&self) -> Result<(), DescriptionError> {
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::NotPositive { what, value }),
        };
        positive("cycle time (ns)", f64::from(self.cycle_time_ns))?;
        positive("servo steps per tick", f64::from(self.servo_steps_per_tick))?;
        for (axis, expected) in self.axes.iter().zip(Axis::ALL) {
            if axis.axis != expected {
                return Err(DescriptionError::AxisOrder { expected: expected.joint(), found: axis.axis.joint() });
            }
            axis.validate(self.cycle_time_s() / f64::from(self.servo_steps_per_tick))?;
            if let Some(homing) = &axis.homing {
                let delay_s = f64::from(self.feedback_delay_ticks) * self.cycle_time_s();
                homing.validate(axis, self.switch_hysteresis_mm, delay_s)?;
            }
        }
        self.retract.validate()?;
        self.wheel.validate(self.is_lathe())?;
        self.validate_insert()?;
        self.wheel_changer.as_ref().map_or(Ok(()), |changer| changer.validate(self))?;
        self.contact.as_ref().map_or(Ok(()), ContactDescription::validate)?;
        self.validate_contact_of_drives()?;
        self.workholding.map_or(Ok(()), |workholding| workholding.validate())?;
        self.thermal.map_or(Ok(()), |thermal| thermal.validate())?;
        self.gauge.map_or(Ok(()), |gauge| gauge.validate())?;
        self.gap_detector.map_or(Ok(()), |detector| detector.validate())?;
        self.key_way_probe.map_or(Ok(()), |probe| probe.validate())?;
        self.loading.map_or(Ok(()), |loading| loading.validate())?;
        self.process.map_or(Ok(()), |process| process.validate())?;
        self.dresser.map_or(Ok(()), |dresser| dresser.validate())?;
        for (what, extent) in [("headstock", self.headstock), ("tailstock", self.tailstock)] {
            if let Some(Extent { from_mm: low, to_mm: high, radius_mm: value }) = extent {
                ordered(what, low, high)?;
                positive(what, value)?;
            }
        }
        positive("origin half window (rad)", self.origin_half_window_rad)?;
        positive("dog length (mm)", self.dog_length_mm)?;
        if !(self.switch_hysteresis_mm >= 0.0 && self.switch_hysteresis_mm.is_finite()) {
            return Err(DescriptionError::Negative {
                what: "switch hysteresis (mm)",
                value: self.switch_hysteresis_mm,
            });
        }
        if self.stations.len() > MAX_STATIONS {
            return Err(DescriptionError::TooManyStations { count: self.stations.len() });
        }
        for pair in self.stations.windows(2) {
            ordered("station position", pair[0].position_mm, pair[1].position_mm)?;
        }
        match self.rotation_sense {
            1 | -1 => Ok(()),
            sense => Err(DescriptionError::RotationSense { sense }),
        }
    }
}

impl MachineDescription {
    /// The force of a servo step is that of the deflection before it. A mass m on the contact's spring k swings by itself when k h/m
    /// comes near the bandwidth w of the loop that damps it. Modes with a mass do not follow within a step; the spring is what remains.
    fn validate_contact_of_drives(&self) -> Result<(), DescriptionError> {
        let axis = self.axis(Axis::X);
        let springs = self.contact.iter().flat_map(|contact| {
            let share = contact.spring_share();
            contact.stiffness.iter().map(move |at| at.n_mm / share)
        });
        let stiffest = springs.fold(0.0, f64::max);
        for drive in [Some(axis.drive), axis.good_drive].into_iter().flatten() {
            let Some(bandwidth) = drive.velocity_loop_rad_s else { continue };
            let step_s = self.cycle_time_s() / f64::from(self.servo_steps_per_tick);
            // 1 N/mm is 1000 N/m.
            let allowed = 0.5 * bandwidth * axis.inertia / step_s / 1e3;
            if stiffest > allowed {
                let what = "machine stiffness (N/mm) for the mass, the velocity loop and the servo step of x_axis";
                return Err(DescriptionError::AboveLimit { what, value: stiffest, allowed });
            }
        }
        Ok(())
    }
}

/// Capability of drives beyond the limits that plans keep: a factor on speed and acceleration. It covers rounding to counts and the
/// tracking of disturbances; a sender that needs more of it has a fault.
pub const DRIVE_HEADROOM: f64 = 1.2;

impl AxisDescription {
    /// Fastest change of speed that its drive can make (mm/s² or rad/s²).
    #[must_use]
    pub fn maximum_acceleration(&self) -> f64 {
        let kept = self.limits.acceleration * DRIVE_HEADROOM;
        self.drive.max_force.map_or(kept, |force| kept.max(force * self.acceleration_per_force()))
    }

    /// Maximum force (N) or torque (N m) of its drive. Default: the value that the motion limits need.
    #[must_use]
    pub fn maximum_force(&self) -> f64 {
        let kept = self.limits.acceleration * DRIVE_HEADROOM / self.acceleration_per_force();
        self.drive.max_force.unwrap_or(kept)
    }

    /// mm/s² per N, or rad/s² per N m.
    fn acceleration_per_force(&self) -> f64 {
        match self.scale {
            // A newton on a kilogram is 1000 mm/s².
            AxisScale::Linear { .. } => 1e3 / self.inertia,
            AxisScale::Rotary { .. } => 1.0 / self.inertia,
        }
    }

    /// Checks that the values describe a possible axis with servo steps of this length (s).
    fn validate(&self, step_s: f64) -> Result<(), DescriptionError> {
        let joint = self.axis.joint();
        let (rotary, counts) = match self.scale {
            AxisScale::Linear { counts_per_mm } => (false, counts_per_mm),
            AxisScale::Rotary { counts_per_turn } => (true, counts_per_turn),
        };
        if rotary != (self.axis == Axis::C) || counts < 1 {
            return Err(DescriptionError::AxisScale { joint, counts });
        }
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::AxisNotPositive { joint, what, value }),
        };
        positive("velocity limit", self.limits.velocity)?;
        positive("acceleration limit", self.limits.acceleration)?;
        positive("jerk limit", self.limits.jerk)?;
        positive("largest following error", self.max_following_error)?;
        positive("smallest following error", self.min_following_error)?;
        for drive in [Some(self.drive), self.good_drive].into_iter().flatten() {
            drive.validate(joint, self.inertia, step_s)?;
        }
        for (what, value) in [("power-up position", self.power_up_position), ("inertia", self.inertia)] {
            if !value.is_finite() {
                return Err(DescriptionError::AxisNotPositive { joint, what, value });
            }
        }
        if let Some((min, max)) = self.soft_limits {
            ordered("soft limits", min, max)?;
        }
        if let Some((min, max)) = self.overtravel {
            ordered("overtravel switches", min, max)?;
        }
        Ok(())
    }
}

/// The count nearest to a position given in counts.
#[allow(clippy::cast_possible_truncation, reason = "positions are bounded by travel, far inside i64")]
pub(crate) fn nearest_count(counts: f64) -> i64 {
    libm::round(counts) as i64
}
