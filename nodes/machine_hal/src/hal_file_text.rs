// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Text of HAL files: the connection of a machine, and a simulation of it by components of LinuxCNC.

use crate::connection::{
    PinDirection, SAMPLER_COLUMNS, SAMPLER_DEPTH, STREAMER_COLUMNS, components, functions, links, own_parameters,
    own_signals, streamer_depth,
};
use crate::simulated_journal::{SimulatedJournal, simulated_journal};
use crate::simulated_references::{SimulatedReferences, simulated_references};
use camwright::machine::description::{Axis, AxisScale, GaugeKind, MachineDescription};
use camwright::math::units::deg_from_rad;
use camwright_files::hal_file::HalConfig;
use camwright_files::machine_file::MachineConfig;
use std::fmt::Write as _;

/// Margin of the simulated drives over the limits of the machine: setpoints within the limits pass unchanged.
const DRIVE_MARGIN: f64 = 1.5;

macro_rules! line {
    ($text:ident) => { $text.push('\n') };
    // A string takes everything.
    ($text:ident, $($rest:tt)*) => { { let _infallible = writeln!($text, $($rest)*); } };
}

/// The components that connect camwright; the drives stand between `streamer` and `sampler`.
fn begin(text: &mut String, hal: &HalConfig, machine: &MachineDescription) {
    line!(text, "loadrt threads name1={} period1={}", hal.thread, machine.cycle_time_ns);
    line!(text, "loadrt streamer depth={} cfg={STREAMER_COLUMNS}", streamer_depth(hal));
    line!(text, "loadrt sampler depth={SAMPLER_DEPTH} cfg={SAMPLER_COLUMNS}");
    line!(text, "loadrt weighted_sum wsum_sizes=16,16");
    line!(text, "# Drives and wheel are off while no setpoints come: before the node starts, and after it has ended.");
    line!(text, "# HAL loads each type of component once: add the names of your own to these lines.");
    for (kind, names) in components(hal) {
        line!(text, "loadrt {kind} names={names}");
    }
}

fn add_functions(text: &mut String, hal: &HalConfig, functions: &[String]) {
    for function in functions {
        line!(text, "addf {function} {}", hal.thread);
    }
}

fn nets(text: &mut String, hal: &HalConfig) {
    for link in links(hal) {
        let (from, arrow, to) = match link.direction {
            PinDirection::In => (&link.ours, "=>", &link.pin),
            PinDirection::Out => (&link.pin, "=>", &link.ours),
            PinDirection::InOut => (&link.pin, "<=>", &link.ours),
        };
        line!(text, "net {} {from} {arrow} {to}", link.signal);
    }
    for own in own_signals(hal) {
        line!(text, "net {} {} => {}", own.signal, own.from, own.to.join(" "));
    }
    for (parameter, value) in own_parameters(hal) {
        line!(text, "setp {parameter} {value}");
    }
}

/// A HAL file for a machine with drives of its own: the connection, and comments where the drives go.
#[must_use]
pub fn connection_text(file: &MachineConfig, hal: &HalConfig) -> String {
    let (mut text, machine) = (String::new(), &file.description);
    line!(
        text,
        "# HAL file of machine {}: the connection to camwright. Print it again with `camwright hal {}`.",
        machine.name,
        machine.name
    );
    line!(text, "# Start it as the user of the node machine_hal, never as root: halrun -I -f FILE.hal");
    line!(text, "#");
    line!(
        text,
        "# NOTHING HERE IS A SAFETY FUNCTION. Emergency stop, doors, limit switches and the brakes of hanging axes are"
    );
    line!(text, "# wired to a safety controller, which takes the power from the drives without any program.");
    line!(text);
    begin(&mut text, hal, machine);
    line!(text);
    line!(text, "# 1. Load the drivers of your drives here, for example one of:");
    line!(text, "#      loadrt hostmot2");
    line!(text, "#      loadrt hm2_eth board_ip=\"192.168.1.121\"          (Mesa 7I92, 7I96)");
    line!(text, "#      loadusr -W lcec_conf ethercat-conf.xml              (EtherCAT)");
    line!(text, "#      loadrt lcec");
    line!(text, "#    and what lies between position and drive, for example: loadrt pid names=pid-c,pid-x,pid-z");
    line!(text);
    let [before, after] = functions(hal);
    add_functions(&mut text, hal, &before);
    line!(
        text,
        "# 2. Add the functions of the drivers here, first the reading one, last the writing one, for example:"
    );
    line!(text, "#      addf hm2_7i96.0.read {}", hal.thread);
    line!(text, "#      addf pid-x.do-pid-calcs {}", hal.thread);
    line!(text, "#      addf hm2_7i96.0.write {}", hal.thread);
    add_functions(&mut text, hal, &after);
    line!(text);
    line!(text, "# 3. The pins of the machine file.");
    nets(&mut text, hal);
    line!(text);
    line!(text, "# 4. Scales, gains and limits of your drives (setp ...).");
    if let Some(gauge) = &hal.gauge {
        let quantity = match machine.gauge.map(|gauge| gauge.kind) {
            Some(GaugeKind::Radius) => "the radius, from the axis of C",
            _ => "the diameter",
        };
        line!(text, "#    The gauge: {} is {quantity} (mm). A component `scale` sets its zero:", gauge.reading);
        line!(
            text,
            "#      loadrt scale names=gauge-mm            (its output is the pin `reading` of the machine file)"
        );
        line!(text, "#      addf gauge-mm {}              (behind the reading function of the driver)", hal.thread);
        line!(
            text,
            "#      net gauge-raw hm2_7i96.0.encoder.03.position => gauge-mm.in   (Mesa: a probe with encoder signals)"
        );
        line!(text, "#      net gauge-raw lcec.0.gauge.ain-0-val => gauge-mm.in           (EtherCAT: an analog input)");
        line!(text, "#      setp gauge-mm.gain 1.0                 (mm for a unit of the driver)");
        line!(text, "#      setp gauge-mm.offset 20.0              (size of the master at which the driver shows 0)");
    }
    line!(text);
    line!(text, "start");
    text
}

/// A HAL file that simulates the machine by components of LinuxCNC, without any hardware. The pins of the machine file must have the
/// names of these components, as those of `params/machines/cam_grinder_hal.yaml` have.
#[must_use]
pub fn simulation_text(file: &MachineConfig, hal: &HalConfig) -> String {
    let (mut text, machine) = (String::new(), &file.description);
    let names = ["c", "x", "z"];
    let each = |suffix: &str| names.map(|name| format!("{name}-{suffix}")).join(",");
    line!(
        text,
        "# Simulation of machine {} by components of LinuxCNC. Print it again with `camwright hal {} --simulate`.",
        machine.name,
        machine.name
    );
    line!(text, "# Start it as the user of the node machine_hal, never as root: halrun -I -f FILE.hal");
    line!(text);
    begin(&mut text, hal, machine);
    let references = simulated_references(names, hal, machine);
    let journal = simulated_journal(hal, machine);
    let referencing = references.iter().flat_map(SimulatedReferences::components);
    let optional: Vec<_> = referencing.chain(journal.iter().flat_map(SimulatedJournal::components)).collect();
    let load = |text: &mut String, kind: &str, names: &[&str]| {
        let of_kind = optional.iter().filter(|of| of.0 == kind).map(|of| of.1.as_str());
        let names: Vec<&str> = names.iter().copied().chain(of_kind).collect();
        if !names.is_empty() {
            line!(text, "loadrt {kind} names={}", names.join(","));
        }
    };
    line!(text, "# A drive follows its command within limits of speed and acceleration.");
    line!(text, "loadrt limit3 names={}", each("drive"));
    line!(text, "# Encoder and command count from where the axis stands at the start.");
    load(&mut text, "sum2", &[&each("command"), &each("encoder"), "c-fraction"]);
    line!(text, "# Faults and limit switches: set in0 to 1.");
    load(&mut text, "or2", &[&each("fault"), &each("limit"), &each("power")]);
    line!(text, "# A drive without power stays where it is.");
    load(&mut text, "mux2", &[&each("powered")]);
    line!(text, "# Origin detector: whole turns of C are taken off.");
    line!(text, "loadrt conv_float_s32 names=c-whole");
    line!(text, "loadrt conv_s32_float names=c-turns");
    load(&mut text, "scale", &["c-in-turns"]);
    let switches: Vec<String> = machine.stations.iter().map(|station| station.switch.to_lowercase()).collect();
    line!(text, "loadrt wcomp names=c-origin,{}", switches.join(","));
    line!(text, "loadrt estop_latch names=chain");
    line!(text, "loadrt timedelay names=wheel-speed");
    for kind in ["comp", "ddt", "sim_spindle", "minmax", "lowpass", "clarkeinv"] {
        load(&mut text, kind, &[]);
    }
    line!(text);
    let [before, after] = functions(hal);
    add_functions(&mut text, hal, &before);
    for name in names {
        for function in ["command", "power", "powered", "drive", "encoder", "fault", "limit"] {
            line!(text, "addf {name}-{function} {}", hal.thread);
        }
    }
    for function in ["c-in-turns", "c-whole", "c-turns", "c-fraction", "c-origin", "chain", "wheel-speed"] {
        line!(text, "addf {function} {}", hal.thread);
    }
    add_functions(&mut text, hal, &switches);
    for (_, function) in &optional {
        line!(text, "addf {function} {}", hal.thread);
    }
    add_functions(&mut text, hal, &after);
    line!(text);
    nets(&mut text, hal);
    line!(text);
    for (name, axis) in names.into_iter().zip(Axis::ALL) {
        let (description, scale) = (machine.axis(axis), hal.axes[axis.index()].scale);
        let unit = match description.scale {
            AxisScale::Rotary { .. } => deg_from_rad(scale),
            AxisScale::Linear { .. } => scale,
        };
        // The encoder of an axis that is to be homed starts at 0.
        let start = if description.needs_homing { 0.0 } else { description.power_up_position * unit };
        line!(text, "net {name}-commanded {name}-command.out => {name}-powered.in1");
        line!(text, "net {name}-has-power {name}-power.out => {name}-powered.sel");
        line!(text, "net {name}-to-drive {name}-powered.out => {name}-drive.in");
        line!(text, "net {name}-from-drive {name}-drive.out => {name}-encoder.in0 {name}-powered.in0");
        line!(text, "setp {name}-command.offset {}", -start);
        line!(text, "setp {name}-encoder.offset {start}");
        line!(text, "setp {name}-drive.maxv {}", DRIVE_MARGIN * description.limits.velocity * unit.abs());
        line!(text, "setp {name}-drive.maxa {}", DRIVE_MARGIN * description.limits.acceleration * unit.abs());
    }
    references.iter().for_each(|references| references.connect(&mut text));
    let turns_per_unit = 1.0 / (360.0 * hal.axes[Axis::C.index()].scale);
    let c = machine.axis(Axis::C);
    let start_turns = deg_from_rad(c.power_up_position) / 360.0;
    line!(text, "net c-from-drive => c-in-turns.in");
    line!(text, "setp c-in-turns.gain {turns_per_unit}");
    line!(text, "setp c-in-turns.offset {start_turns}");
    line!(text, "net c-turned c-in-turns.out => c-whole.in c-fraction.in0");
    line!(text, "net c-whole-turns c-whole.out => c-turns.in");
    line!(text, "net c-turns-off c-turns.out => c-fraction.in1");
    line!(text, "setp c-fraction.gain1 -1");
    line!(text, "net c-of-turn c-fraction.out => c-origin.in");
    line!(text, "setp c-origin.min 0");
    line!(text, "setp c-origin.max {}", deg_from_rad(machine.origin_half_window_rad) / 360.0);
    let z = &hal.axes[Axis::Z.index()];
    for (switch, station) in switches.iter().zip(&machine.stations) {
        line!(text, "net camwright-z-axis-feedback => {switch}.in");
        line!(text, "setp {switch}.min {}", station.position_mm * z.scale);
        line!(text, "setp {switch}.max {}", (station.position_mm + machine.dog_length_mm) * z.scale);
    }
    if let Some(journal) = journal {
        journal.connect(&mut text);
    }
    line!(text, "# The emergency stop chain is closed: ok-in to 0 opens it, a pulse of reset closes it again.");
    line!(text, "setp chain.ok-in 1");
    line!(text, "setp chain.reset 1");
    line!(text, "setp wheel-speed.on-delay {}", machine.wheel.spin_up_s);
    line!(text, "setp wheel-speed.off-delay 0");
    line!(text);
    line!(text, "start");
    text
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use camwright_files::locate::locate;
    use camwright_files::machine_file;
    use std::collections::BTreeSet;

    /// Keys of a grinder whose X is homed at a switch and the next index mark.
    const HOMED: [&str; 4] = [
        "x_axis.home={search_velocity_mm_s: 5, latch_velocity_mm_s: -2, switch_mm: 164, home_mm: 150, use_index: true, index_pitch_mm: 8}",
        "hal.x_axis.home=x-home.out",
        "hal.x_axis.index_enable=x-index.index-enable",
        "hal.x_axis.index_position=x-since-mark.out",
    ];

    const TWO_READINGS: &str =
        "hal.gauge={reading: gauge-reading.out, second_reading: gauge-second-reading.out, valid: gauge-valid.out}";

    fn file(overrides: &[&str]) -> MachineConfig {
        let located = locate("machines", "cam_grinder_hal", "yaml", None).expect("it is shipped");
        let overrides: Vec<String> = overrides.iter().map(|key| (*key).to_owned()).collect();
        machine_file::parse(&located.path, &located.text, &overrides).expect("it is a machine")
    }

    /// The shipped grinder behind HAL, with these keys.
    pub(crate) fn with_hal(overrides: &[&str]) -> (MachineDescription, HalConfig) {
        let file = file(overrides);
        (file.description, file.hal.expect("it has drives"))
    }

    /// The shipped grinder behind HAL.
    pub(crate) fn grinder() -> (MachineDescription, HalConfig) {
        with_hal(&[])
    }

    /// The same, with index marks on X.
    pub(crate) fn grinder_with_index() -> (MachineDescription, HalConfig) {
        with_hal(&HOMED)
    }

    /// Every component is loaded before it is used, every function runs once, and every signal has one writer.
    #[test]
    fn a_simulation_is_complete() {
        let two = ["gauge.kind=diameter", "gauge.second_behind_wheel_deg=210", TWO_READINGS];
        let none = ["gauge=null", "hal.gauge=null"];
        let texts = [&[][..], &HOMED, &two, &none].into_iter().flat_map(|overrides| {
            let file = file(overrides);
            let hal = file.hal.clone().expect("it has drives");
            [simulation_text(&file, &hal), connection_text(&file, &hal)].map(|text| (hal.clone(), text))
        });
        for (hal, text) in texts {
            let lines = || text.lines().filter(|line| !line.starts_with('#'));
            let functions: Vec<&str> = lines().filter_map(|line| line.strip_prefix("addf ")).collect();
            assert_eq!(functions.iter().collect::<BTreeSet<_>>().len(), functions.len());
            assert!(functions[0].starts_with("streamer.0") && functions[functions.len() - 1].starts_with("sampler.0"));
            for link in links(&hal) {
                let pins =
                    lines().filter(|line| line.starts_with("net ") && line.split(' ').any(|word| word == link.pin));
                assert_eq!(pins.count(), 1, "{}", link.pin);
            }
            let mut written = BTreeSet::new();
            for line in lines().filter(|line| line.contains(" => ")) {
                let words: Vec<&str> = line.split(' ').collect();
                if words[2] != "=>" {
                    assert!(written.insert(words[1]), "{} has two writers", words[1]);
                }
            }
        }
    }
}
