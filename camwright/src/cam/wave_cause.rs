// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Causes of waves on a ground part: a vibration leaves as many waves per turn as it has periods in that time.

use crate::machine::description::{Axis, MachineDescription};

/// Vibration of a machine that leaves waves on the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaveCause {
    /// Rotation of the wheel, or a multiple of it: unbalance, runout, an uneven rim.
    Wheel { multiple: u32 },
    /// First mode of the structure of an axis.
    Structure { axis: Axis },
    /// Mode of machine and part at the contact, by its place in the machine file.
    ContactMode { index: usize },
    /// Position and velocity loop of an axis, which rings.
    Drive { axis: Axis },
    /// Regeneration: waves of the turn before feed a vibration that the forecast of the pass lets grow.
    Chatter,
}

/// Largest multiple of the wheel's rotation.
const MAX_MULTIPLE: u32 = 3;

/// Damping of the loops of a drive below which they ring: their response to a force has a peak.
const RINGING_DAMPING: f64 = 0.5;

/// Ratio of the largest to the smallest speed of the part up to which the waves of one vibration count as even.
const MAX_SPEED_RATIO: f64 = 1.02;

impl WaveCause {
    /// Finds the cause of waves on a part that turns in a range of speeds (slowest and fastest, rad/s). `None` where no vibration of the
    /// machine has as many periods in a turn, where several have, or where the speed varies too much for even waves. `growing_rad_s` are
    /// the frequencies of the waves whose growth is forecast; each belongs to a mode or a loop, which then is not another candidate.
    #[must_use]
    pub fn find(
        waves_per_turn: usize,
        speed_range_rad_s: (f64, f64),
        machine: &MachineDescription,
        wheel_radius_mm: f64,
        growing_rad_s: &[f64],
    ) -> Option<Self> {
        let (slowest, fastest) = speed_range_rad_s;
        // Also where it is not a number.
        let is_even = fastest <= MAX_SPEED_RATIO * slowest;
        if !is_even {
            return None;
        }
        let wheel_rad_s = machine.wheel.speed_rad_s(wheel_radius_mm);
        let rotations =
            (1..=MAX_MULTIPLE).map(|multiple| (Self::Wheel { multiple }, f64::from(multiple) * wheel_rad_s));
        let structures = Axis::ALL.into_iter().filter_map(|axis| {
            let structure = machine.axes[axis.index()].drive.structure?;
            Some((Self::Structure { axis }, structure.frequency_rad_s))
        });
        let modes = machine.contact.iter().flat_map(|contact| contact.modes.iter().enumerate());
        let modes = modes.map(|(index, mode)| (Self::ContactMode { index }, mode.frequency_rad_s));
        let drives =
            Axis::ALL.into_iter().filter_map(|axis| Some((Self::Drive { axis }, ringing_rad_s(machine, axis)?)));
        let waves = waves_per_turn as f64;
        let fits =
            |frequency_rad_s: f64| (frequency_rad_s / fastest - 0.5..=frequency_rad_s / slowest + 0.5).contains(&waves);
        let is_chatter = growing_rad_s.iter().any(|frequency_rad_s| fits(*frequency_rad_s));
        let own = structures.chain(modes).chain(drives).filter(|_| !is_chatter);
        let chatter = is_chatter.then_some(Self::Chatter);
        let fitting = rotations.chain(own).filter(|(_, frequency_rad_s)| fits(*frequency_rad_s));
        let mut fitting = fitting.map(|(cause, _)| cause).chain(chatter);
        let cause = fitting.next()?;
        fitting.next().is_none().then_some(cause)
    }
}

/// Frequency at which the loops of an axis ring: s² + ω s + ω k_v of the velocity loop ω around the position loop k_v. `None`: they are damped.
fn ringing_rad_s(machine: &MachineDescription, axis: Axis) -> Option<f64> {
    let drive = &machine.axes[axis.index()].drive;
    let (loop_rad_s, kv_1_s) = (drive.velocity_loop_rad_s?, drive.kv_1_s * (1.0 + drive.gain_error));
    let natural_rad_s = libm::sqrt(loop_rad_s * kv_1_s);
    (loop_rad_s < 2.0 * RINGING_DAMPING * natural_rad_s).then_some(natural_rad_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::contact::{ContactDescription, ContactMode, StiffnessAt};
    use crate::machine::drive::Structure;
    use crate::machine::reference::cam_grinder;
    use alloc::vec;

    /// 45 m/s at 300 mm are 150 rad/s: 25 periods in a turn at 6 rad/s.
    #[test]
    fn waves_have_the_vibration_with_as_many_periods_in_a_turn() {
        let mut machine = cam_grinder();
        machine.wheel.surface_speed_m_s = 45.0;
        let find = |machine: &MachineDescription, waves, range| WaveCause::find(waves, range, machine, 300.0, &[]);
        for (waves, cause) in [
            (24, None),
            (25, Some(WaveCause::Wheel { multiple: 1 })),
            (26, None),
            (50, Some(WaveCause::Wheel { multiple: 2 })),
            (75, Some(WaveCause::Wheel { multiple: 3 })),
            (100, None),
        ] {
            assert_eq!(find(&machine, waves, (6.0, 6.0)), cause, "{waves}");
        }
        assert_eq!(find(&machine, 25, (6.0, 6.2)), None, "the speed varies");
        assert_eq!(find(&machine, 25, (f64::NAN, f64::NAN)), None);

        let structure = |frequency_rad_s: f64| Some(Structure { frequency_rad_s, damping: 0.02, mass_share: 0.3 });
        machine.axes[Axis::X.index()].drive.structure = structure(252.0);
        assert_eq!(find(&machine, 42, (6.0, 6.0)), Some(WaveCause::Structure { axis: Axis::X }));
        machine.axes[Axis::X.index()].drive.structure = structure(151.0);
        assert_eq!(find(&machine, 25, (6.0, 6.0)), None, "the wheel or the structure");
    }

    /// 60 rad/s around 90 1/s ring at √(60 · 90) rad/s with a damping of 0.41; 90 around 60 does not: 0.61.
    #[test]
    fn loops_that_ring_and_modes_of_the_contact_are_causes() {
        let mut machine = cam_grinder();
        let find = |machine: &MachineDescription, waves, growing: &[f64]| {
            WaveCause::find(waves, (1.0, 1.0), machine, 300.0, growing)
        };
        let drive = &mut machine.axes[Axis::X.index()].drive;
        (drive.velocity_loop_rad_s, drive.kv_1_s, drive.gain_error) = (Some(60.0), 90.0, 0.0);
        assert_eq!(find(&machine, 73, &[]), Some(WaveCause::Drive { axis: Axis::X }));
        assert_eq!(find(&machine, 75, &[]), None);
        assert_eq!(find(&machine, 73, &[73.2]), Some(WaveCause::Chatter), "the loops are what chatters");
        let drive = &mut machine.axes[Axis::X.index()].drive;
        (drive.velocity_loop_rad_s, drive.kv_1_s) = (Some(90.0), 60.0);
        assert_eq!(find(&machine, 73, &[]), None);

        let mode = |frequency_rad_s| ContactMode { frequency_rad_s, damping: 0.03, compliance_share: 0.4 };
        machine.contact = Some(ContactDescription {
            stiffness: vec![StiffnessAt { z_mm: 0.0, n_mm: 20e3 }],
            grinding_n_mm2: 2e3,
            threshold_n_mm: 0.0,
            part_share: 0.5,
            modes: vec![mode(880.0), mode(1500.0)],
        });
        assert_eq!(find(&machine, 1500, &[]), Some(WaveCause::ContactMode { index: 1 }));
        assert_eq!(find(&machine, 930, &[]), None);
        // A wave that chatters has a frequency above that of its mode.
        assert_eq!(find(&machine, 930, &[930.0]), Some(WaveCause::Chatter));
    }
}
