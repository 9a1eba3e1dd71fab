// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Forecast for one pass of one lobe on a machine.

use super::compliance::{ContactCompliance, VibrationMode};
use super::drive_compliance::DriveCompliance;
use super::regeneration::{RegenerativeCut, WaveGrowth, WheelRegeneration};
use super::stability_lobes::{LobePoint, StabilityLobes};
use crate::machine::description::{Axis, MachineDescription};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Work speeds that are tried for a stable one.
const SPEEDS: u32 = 600;

/// One pass of one lobe.
#[derive(Debug, Clone, Copy)]
pub struct ChatterRequest<'a> {
    pub machine: &'a MachineDescription,
    /// Station of the lobe.
    pub station: &'a str,
    /// Compliance of the part on its supports at the lobe (mm/N); 0: the part is as stiff as the machine's contact says.
    pub part_mm_n: f64,
    /// Width of the lobe (mm).
    pub width_mm: f64,
    /// Mean radius of the lobe (mm).
    pub radius_mm: f64,
    pub wheel_radius_mm: f64,
    /// Time of a turn in the pass (s).
    pub turn_s: f64,
    /// Infeed of a turn (mm).
    pub infeed_per_turn_mm: f64,
}

/// Range of work speeds (rad/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRange {
    pub slowest_rad_s: f64,
    pub fastest_rad_s: f64,
}

/// Stability of one pass.
#[derive(Debug, Clone, PartialEq)]
pub struct ChatterForecast {
    pub cut: RegenerativeCut,
    /// Wave of the part that grows fastest or decays slowest; `None`: nothing vibrates.
    pub part: Option<WaveGrowth>,
    /// The same of the wheel; `None`: it does not wear.
    pub wheel: Option<WaveGrowth>,
    /// Boundary at the planned work speed.
    pub boundary: LobePoint,
    /// Factor that a turn leaves of long waves, as the contact law has it.
    pub long_waves_per_turn: f64,
    /// Length of the dominant wave on the part (mm).
    pub wave_mm: Option<f64>,
    /// Length of the contact of wheel and part at the infeed of the pass (mm): it wipes shorter waves out.
    pub contact_mm: f64,
}

impl ContactCompliance {
    /// Compliance of a machine with the table at a position (mm); `None` of a rigid one.
    #[must_use]
    pub fn from_machine(machine: &MachineDescription, z_mm: f64) -> Option<Self> {
        let contact = machine.contact.as_ref()?;
        let static_n_mm = contact.machine_n_mm(z_mm);
        let modes: Vec<VibrationMode> = contact
            .modes
            .iter()
            .map(|mode| VibrationMode {
                frequency_rad_s: mode.frequency_rad_s,
                damping: mode.damping,
                stiffness_n_mm: static_n_mm / mode.compliance_share,
            })
            .collect();
        let step_s = machine.cycle_time_s() / f64::from(machine.servo_steps_per_tick);
        let drive = DriveCompliance::new(machine.axis(Axis::X), step_s);
        Some(Self { spring_mm_n: contact.spring_share() / static_n_mm, modes, drive })
    }
}

impl ChatterForecast {
    /// Forecast of a pass; `None` on a rigid machine, or without its station.
    #[must_use]
    pub fn new(request: &ChatterRequest<'_>) -> Option<Self> {
        let ChatterRequest {
            machine,
            station,
            part_mm_n,
            width_mm,
            radius_mm,
            wheel_radius_mm,
            turn_s,
            infeed_per_turn_mm,
        } = *request;
        let law = machine.contact_law(station, width_mm)?.in_series(part_mm_n);
        let rigid_part = ContactCompliance::from_machine(machine, machine.station(station)?.position_mm)?;
        let compliance = rigid_part.with_part(part_mm_n);
        let part_mm_s = TURN_RAD * radius_mm / turn_s;
        let wheel_speed =
            (1e3 * machine.wheel.surface_speed_m_s, TURN_RAD / machine.wheel.speed_rad_s(wheel_radius_mm));
        let wheel = machine
            .wheel
            .grinding_ratio
            .map(|ratio| WheelRegeneration::new(law.grinding_n_mm(), ratio, part_mm_s, wheel_speed));
        let lobes = StabilityLobes::new(&compliance, [TURN_RAD / turn_s]);
        let cut = RegenerativeCut { compliance, grinding_n_mm: law.grinding_n_mm(), turn_s, wheel };
        let part = cut.dominant();
        Some(Self {
            part,
            wheel: cut.dominant_of_wheel(),
            boundary: *lobes.points.first()?,
            long_waves_per_turn: law.decay(),
            wave_mm: part.map(|wave| TURN_RAD * radius_mm / wave.waves_per_turn),
            contact_mm: libm::sqrt(infeed_per_turn_mm * 2.0 / (1.0 / wheel_radius_mm + 1.0 / radius_mm)),
            cut,
        })
    }

    /// No wave of the part grows.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.part.is_none_or(|wave| !wave.is_growing())
    }

    /// Cutting stiffness at the boundary over that of the cut; above 1 it is stable. Infinite where nothing chatters.
    #[must_use]
    pub fn margin(&self) -> f64 {
        self.boundary.grinding_n_mm / self.cut.grinding_n_mm
    }

    /// Boundary over a range of work speeds, in equal steps.
    #[must_use]
    pub fn lobes(&self, range: SpeedRange, count: u32) -> StabilityLobes {
        let step = (range.fastest_rad_s - range.slowest_rad_s) / f64::from(count.max(2) - 1);
        StabilityLobes::new(&self.cut.compliance, (0..count.max(2)).map(|i| range.slowest_rad_s + step * f64::from(i)))
    }

    /// Nearest stable work speeds below and above the planned one (rad/s).
    #[must_use]
    pub fn nearest_stable_rad_s(&self, range: SpeedRange) -> (Option<f64>, Option<f64>) {
        let planned = TURN_RAD / self.cut.turn_s;
        let lobes = self.lobes(range, SPEEDS);
        let stable = |point: &&LobePoint| point.grinding_n_mm > self.cut.grinding_n_mm;
        let speeds = || lobes.points.iter().filter(stable).map(|point| point.speed_rad_s);
        let below = speeds().rfind(|speed| *speed < planned);
        let above = speeds().find(|speed| *speed > planned);
        (below, above)
    }
}
