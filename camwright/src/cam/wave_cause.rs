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
}

/// Largest multiple of the wheel's rotation.
const MAX_MULTIPLE: u32 = 3;

/// Ratio of the largest to the smallest speed of the part up to which the waves of one vibration count as even.
const MAX_SPEED_RATIO: f64 = 1.02;

impl WaveCause {
    /// Finds the cause of waves on a part that turns in a range of speeds (slowest and fastest, rad/s). `None` where no vibration of the
    /// machine has as many periods in a turn, where several have, or where the speed varies too much for even waves.
    #[must_use]
    pub fn find(
        waves_per_turn: usize,
        speed_range_rad_s: (f64, f64),
        machine: &MachineDescription,
        wheel_radius_mm: f64,
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
        let waves = waves_per_turn as f64;
        let fits =
            |frequency_rad_s: f64| (frequency_rad_s / fastest - 0.5..=frequency_rad_s / slowest + 0.5).contains(&waves);
        let mut fitting = rotations.chain(structures).filter(|(_, frequency_rad_s)| fits(*frequency_rad_s));
        let (cause, _) = fitting.next()?;
        fitting.next().is_none().then_some(cause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::drive::Structure;
    use crate::machine::reference::cam_grinder;

    /// 45 m/s at 300 mm are 150 rad/s: 25 periods in a turn at 6 rad/s.
    #[test]
    fn waves_have_the_vibration_with_as_many_periods_in_a_turn() {
        let mut machine = cam_grinder();
        machine.wheel.surface_speed_m_s = 45.0;
        let find = |machine: &MachineDescription, waves, range| WaveCause::find(waves, range, machine, 300.0);
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
}
