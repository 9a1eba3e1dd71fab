// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Effect of single drive flaws: simulation with each flaw removed.

use super::{DrivesForm, DrivesResult, TurningDrives, TurningDrivesError};
use crate::machine::description::{Axis, DriveSettings, MachineDescription};
use alloc::vec::Vec;
use core::fmt;

/// Something of a drive that leaves an error on the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveFlaw {
    /// Its feed-forward of speed and acceleration is less than whole, or more.
    FeedForward,
    /// Its gain is not what it is set to.
    GainError,
    /// Friction is in its way.
    Friction,
    /// Oscillation of the load.
    Structure,
    /// Play between encoder and tool.
    Backlash,
    /// Steps and noise of its encoder.
    Encoder,
    Everything,
}

impl DriveFlaw {
    pub const ALL: [DriveFlaw; 7] = [
        DriveFlaw::FeedForward,
        DriveFlaw::GainError,
        DriveFlaw::Friction,
        DriveFlaw::Structure,
        DriveFlaw::Backlash,
        DriveFlaw::Encoder,
        DriveFlaw::Everything,
    ];

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            DriveFlaw::FeedForward => "feed-forward",
            DriveFlaw::GainError => "gain error",
            DriveFlaw::Friction => "friction",
            DriveFlaw::Structure => "structure",
            DriveFlaw::Backlash => "backlash",
            DriveFlaw::Encoder => "encoder",
            DriveFlaw::Everything => "everything",
        }
    }

    /// A drive without it.
    #[must_use]
    pub fn left_out_of(self, drive: DriveSettings) -> DriveSettings {
        match self {
            DriveFlaw::FeedForward => {
                DriveSettings { velocity_feed_forward: 1.0, acceleration_feed_forward: 1.0, ..drive }
            }
            DriveFlaw::GainError => DriveSettings { gain_error: 0.0, ..drive },
            DriveFlaw::Friction => {
                DriveSettings { coulomb_friction: 0.0, viscous_friction: 0.0, friction_feed_forward: 0.0, ..drive }
            }
            DriveFlaw::Structure => DriveSettings { structure: None, ..drive },
            DriveFlaw::Backlash => DriveSettings { backlash: 0.0, ..drive },
            DriveFlaw::Encoder => drive.with_exact_encoder(),
            DriveFlaw::Everything => DriveSettings::IDEAL,
        }
    }
}

/// Whose drives are without a flaw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlawAxes {
    One(Axis),
    /// All but one axis': what is left is that one's alone.
    AllBut(Axis),
    All,
}

impl FlawAxes {
    fn has(self, axis: Axis) -> bool {
        match self {
            FlawAxes::One(one) => axis == one,
            FlawAxes::AllBut(one) => axis != one,
            FlawAxes::All => true,
        }
    }
}

/// A flaw of some drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisFlaw {
    pub axes: FlawAxes,
    /// Removed flaw.
    pub flaw: DriveFlaw,
}

impl AxisFlaw {
    /// All that are looked at: every flaw of every axis and of all of them, and everything of all but one.
    fn all() -> impl Iterator<Item = Self> {
        let one = |axis: Axis| DriveFlaw::ALL.map(|flaw| Self { axes: FlawAxes::One(axis), flaw });
        // Without everything of all axes nothing is left.
        let all = DriveFlaw::ALL.into_iter().filter(|flaw| *flaw != DriveFlaw::Everything);
        let but = |axis: Axis| Self { axes: FlawAxes::AllBut(axis), flaw: DriveFlaw::Everything };
        let all = all.map(|flaw| Self { axes: FlawAxes::All, flaw });
        Axis::ALL.into_iter().flat_map(one).chain(all).chain(Axis::ALL.into_iter().map(but))
    }

    /// A machine without it; `None` where it lacks it, or no more of it than one axis alone.
    fn left_out_of(self, machine: &MachineDescription) -> Option<MachineDescription> {
        let mut other = machine.clone();
        let mut changed = 0;
        for axis in Axis::ALL.into_iter().filter(|axis| self.axes.has(*axis)) {
            let drive = &mut other.axes[axis.index()].drive;
            let without = self.flaw.left_out_of(*drive);
            changed += u32::from(without != *drive);
            *drive = without;
        }
        let min = if matches!(self.axes, FlawAxes::One(_)) { 1 } else { 2 };
        (changed >= min).then_some(other)
    }
}

impl fmt::Display for AxisFlaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let flaw = self.flaw.name();
        match self.axes {
            FlawAxes::One(axis) => write!(f, "{flaw} of {}", axis.joint()),
            FlawAxes::AllBut(axis) => write!(f, "{flaw} of all axes but {}", axis.joint()),
            FlawAxes::All => write!(f, "{flaw} of all axes"),
        }
    }
}

/// Form error without a flaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlawEffect {
    pub of: AxisFlaw,
    /// Form error of the other flaws.
    pub form: DrivesForm,
}

impl TurningDrives<'_> {
    /// Computes the form error without each flaw of the drives, for single axes and all axes, and the error of each axis alone; the removal
    /// with the smallest error first.
    ///
    /// Flaws hide one another: X and C that lag alike stay on the path, and an X that does not lag any more behind a C that does leaves
    /// more than both did. So what their absence gains does not add up; what an axis leaves alone no change of the others takes away.
    ///
    /// # Errors
    /// See [`Self::form`].
    pub fn without_flaws(
        &self,
        machine: &MachineDescription,
        mut report: impl FnMut(&DrivesResult),
    ) -> Result<Vec<FlawEffect>, TurningDrivesError> {
        let mut found = Vec::new();
        for of in AxisFlaw::all() {
            let Some(other) = of.left_out_of(machine) else { continue };
            let without = FlawEffect { of, form: self.form(&other)? };
            report(&DrivesResult::Flaw(without));
            found.push(without);
        }
        found.sort_by(|a, b| a.form.beyond_mm.total_cmp(&b.form.beyond_mm));
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::description::Structure;
    use crate::machine::reference::lathe;

    const BAD: DriveSettings = DriveSettings {
        gain_error: 0.01,
        velocity_feed_forward: 0.9,
        acceleration_feed_forward: 0.8,
        velocity_loop_rad_s: Some(500.0),
        velocity_integral_s: Some(0.01),
        coulomb_friction: 1.0,
        viscous_friction: 0.1,
        friction_feed_forward: 0.5,
        backlash: 0.001,
        structure: Some(Structure { frequency_rad_s: 1000.0, damping: 0.05, mass_share: 0.1 }),
        encoder_step_counts: 2.0,
        encoder_noise_counts: 0.3,
        ..DriveSettings::IDEAL
    };

    /// One after the other omitted they are all gone, and nothing is left but the loops.
    #[test]
    fn a_flaw_that_is_left_out_is_gone_and_nothing_else() {
        let loops = DriveSettings {
            velocity_loop_rad_s: BAD.velocity_loop_rad_s,
            velocity_integral_s: BAD.velocity_integral_s,
            ..DriveSettings::IDEAL
        };
        let flaws = || DriveFlaw::ALL.into_iter().filter(|flaw| *flaw != DriveFlaw::Everything);
        assert_eq!(flaws().fold(BAD, |drive, flaw| flaw.left_out_of(drive)), loops);
        for flaw in flaws() {
            let others = flaws().filter(|other| *other != flaw).fold(BAD, |drive, other| other.left_out_of(drive));
            assert!(flaw.left_out_of(BAD) != BAD && others != loops, "{}", flaw.name());
            assert_eq!(flaw.left_out_of(others), loops, "{}", flaw.name());
        }
        assert_eq!(DriveFlaw::Everything.left_out_of(BAD), DriveSettings::IDEAL);
    }

    #[test]
    fn what_a_machine_has_not_got_is_not_left_out() {
        let mut machine = lathe().with_drives(DriveSettings::IDEAL);
        let of = |axes| AxisFlaw { axes, flaw: DriveFlaw::Backlash };
        machine.axes[Axis::Z.index()].drive = BAD;
        assert_eq!(of(FlawAxes::One(Axis::X)).left_out_of(&machine), None);
        assert_eq!(of(FlawAxes::All).left_out_of(&machine), None, "that is Z's alone");
        let without = of(FlawAxes::One(Axis::Z)).left_out_of(&machine).expect("Z has play");
        assert!(without.axis(Axis::Z).drive.backlash == 0.0 && without.axis(Axis::X) == machine.axis(Axis::X));
        machine.axes[Axis::X.index()].drive = BAD;
        let without = of(FlawAxes::All).left_out_of(&machine).expect("two have play");
        assert!(without.axes.iter().all(|axis| axis.drive.backlash == 0.0));
        let alone = AxisFlaw { axes: FlawAxes::AllBut(Axis::Z), flaw: DriveFlaw::Everything };
        assert_eq!(alone.left_out_of(&machine), None, "C is ideal: that is X's alone");
        machine.axes[Axis::C.index()].drive = BAD;
        let alone = alone.left_out_of(&machine).expect("C and X");
        assert!(alone.axis(Axis::C).drive == DriveSettings::IDEAL && alone.axis(Axis::Z) == machine.axis(Axis::Z));
    }
}
