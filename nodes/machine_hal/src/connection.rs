// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Signals between the pins of a machine and the columns of `streamer` and `sampler`.

use camwright::machine::description::{AXIS_COUNT, Axis};
use camwright_files::hal_file::{HalConfig, HalGauge, HalIndex};

/// Columns of the streamer: sequence number; C, X, Z; drive of C, X, Z on; wheel runs; speed of the wheel.
pub(crate) const STREAMER_COLUMNS: &str = "ufffbbbbf";
/// Columns of the sampler: sequence number; queued setpoints; C, X, Z; inputs of the machine; switches of the stations; error of the
/// period (ns); C, X, Z since their index marks; readings of the gauge and of a second one.
pub(crate) const SAMPLER_COLUMNS: &str = "usfffsssfffff";
/// Column of the sampler with the reading of the gauge.
const READING: usize = 11;
/// Samples that wait for this program: ten seconds at 1 kHz.
pub(crate) const SAMPLER_DEPTH: u32 = 10_000;
/// Time without setpoints after which HAL switches drives and wheel off (s): longer than any stop, and than a pause of the computer.
pub(crate) const SILENCE_S: f64 = 0.5;
/// Component of HAL that is on once the queue has been empty for this time.
const SILENCE: &str = "camwright-silence";
/// Truth table of a gate: the order is on, and the queue is not silent.
const GATE: &str = "0x2";
/// Component of HAL that measures the servo period.
const PERIOD: &str = "camwright-period";

/// Bits of the word of inputs.
pub(crate) const ESTOP: u32 = 0;
pub(crate) const FAULTS: u32 = 1;
pub(crate) const AT_SPEED: u32 = 4;
pub(crate) const ORIGIN: u32 = 5;
pub(crate) const HOMES: u32 = 6;
pub(crate) const LIMITS: u32 = 9;
/// On while an encoder waits for its index mark; off in the period in which it has passed one.
pub(crate) const INDEXES: u32 = 12;
/// On while the gauge measures.
pub(crate) const GAUGE: u32 = 15;

/// Setpoints that the queue of HAL can hold: twice what waits in it, so that it is never full.
pub(crate) fn streamer_depth(hal: &HalConfig) -> u32 {
    2 * hal.fifo_ticks + 16
}

/// Kind of value of a pin, as `halcmd show pin` prints it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PinType {
    Bit,
    Float,
}

impl PinType {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bit => "bit",
            Self::Float => "float",
        }
    }
}

/// Direction of a pin of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PinDirection {
    /// The machine reads it.
    In,
    /// The machine writes it.
    Out,
    /// Both sides write it.
    InOut,
}

impl PinDirection {
    /// Its name as `halcmd show pin` prints it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::In => "IN",
            Self::Out => "OUT",
            Self::InOut => "I/O",
        }
    }

    /// Returns whether a pin with the direction that `halcmd` prints serves.
    pub(crate) fn is_served_by(self, shown: &str) -> bool {
        shown == self.name() || (self != Self::InOut && shown == Self::InOut.name())
    }
}

/// A pin of the machine on a signal with a pin of this side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PinLink {
    /// Key of the machine file.
    pub(crate) key: String,
    pub(crate) pin: String,
    pub(crate) kind: PinType,
    pub(crate) direction: PinDirection,
    pub(crate) signal: String,
    /// Pin of this side.
    pub(crate) ours: String,
}

/// Links of a machine.
pub(crate) fn links(hal: &HalConfig) -> Vec<PinLink> {
    let mut links = Vec::new();
    let mut link = |key: String, pin: &str, kind, direction, ours: String| {
        let signal = signal(key.trim_start_matches("hal."));
        links.push(PinLink { key, pin: pin.to_owned(), kind, direction, signal, ours });
    };
    for (axis, pins) in Axis::ALL.into_iter().zip(&hal.axes) {
        let (name, index) = (axis.joint(), axis.index());
        let key = |key: &str| format!("hal.{name}.{key}");
        link(key("command"), &pins.command, PinType::Float, PinDirection::In, format!("streamer.0.pin.{}", 1 + index));
        link(
            key("feedback"),
            &pins.feedback,
            PinType::Float,
            PinDirection::Out,
            format!("sampler.0.pin.{}", 2 + index),
        );
        link(key("enable"), &pins.enable, PinType::Bit, PinDirection::In, format!("{}.out", gate(name)));
        for (name, pin, first) in
            [("fault", &pins.fault, FAULTS), ("home", &pins.home, HOMES), ("limit", &pins.limit, LIMITS)]
        {
            if let Some(pin) = pin {
                link(key(name), pin, PinType::Bit, PinDirection::Out, word_bit(first, axis));
            }
        }
        if let Some(HalIndex { enable, position }) = &pins.index {
            link(key("index_enable"), enable, PinType::Bit, PinDirection::InOut, format!("{}.out", arming(axis)));
            let column = format!("sampler.0.pin.{}", 8 + index);
            link(key("index_position"), position, PinType::Float, PinDirection::Out, column);
        }
    }
    link("hal.wheel.run".to_owned(), &hal.wheel_run, PinType::Bit, PinDirection::In, format!("{}.out", gate("wheel")));
    if let Some(pin) = &hal.wheel_speed_rpm {
        link("hal.wheel.speed_rpm".to_owned(), pin, PinType::Float, PinDirection::In, "streamer.0.pin.8".to_owned());
    }
    link("hal.wheel.at_speed".to_owned(), &hal.wheel_at_speed, PinType::Bit, PinDirection::Out, wired(AT_SPEED));
    link("hal.estop".to_owned(), &hal.estop, PinType::Bit, PinDirection::Out, wired(ESTOP));
    link("hal.origin".to_owned(), &hal.origin, PinType::Bit, PinDirection::Out, wired(ORIGIN));
    for (index, (switch, pin)) in hal.stations.iter().enumerate() {
        link(format!("hal.stations.{switch}"), pin, PinType::Bit, PinDirection::Out, format!("wsum.1.bit.{index}.in"));
    }
    if let Some(HalGauge { reading, second_reading, valid }) = &hal.gauge {
        let mut float = |key: &str, pin: &str, column: usize| {
            let ours = format!("sampler.0.pin.{column}");
            link(format!("hal.gauge.{key}"), pin, PinType::Float, PinDirection::Out, ours);
        };
        float("reading", reading, READING);
        if let Some(pin) = second_reading {
            float("second_reading", pin, READING + 1);
        }
        if let Some(pin) = valid {
            link("hal.gauge.valid".to_owned(), pin, PinType::Bit, PinDirection::Out, wired(GAUGE));
        }
    }
    links
}

/// Signal of a key of the section `hal`.
fn signal(key: &str) -> String {
    format!("camwright-{}", key.replace(['.', '_'], "-"))
}

/// Pin of a bit of the word of inputs.
fn wired(bit: u32) -> String {
    format!("wsum.0.bit.{bit}.in")
}

/// Pin of an axis' bit of the word of inputs.
fn word_bit(first: u32, axis: Axis) -> String {
    wired((first..).nth(axis.index()).unwrap_or(first))
}

/// Component of HAL that makes the encoder of an axis wait for its next index mark, in every period.
fn arming(axis: Axis) -> String {
    signal(&format!("{}.index", axis.joint()))
}

/// Axes with index marks.
fn indexed(hal: &HalConfig) -> impl Iterator<Item = Axis> {
    Axis::ALL.into_iter().filter(|axis| hal.axes[axis.index()].index.is_some())
}

/// Component of HAL that switches a drive, or the wheel, on as ordered, while setpoints come.
fn gate(of: &str) -> String {
    format!("camwright-{}-on", of.replace('_', "-"))
}

/// The gates: component, and the pin of the order.
fn gates() -> Vec<(String, String)> {
    let of_axes = Axis::ALL.map(|axis| (axis.joint(), 1 + AXIS_COUNT + axis.index()));
    let gates = of_axes.into_iter().chain([("wheel", 7)]);
    gates.map(|(of, pin)| (gate(of), format!("streamer.0.pin.{pin}"))).collect()
}

/// A signal that stays on this side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OwnSignal {
    pub(crate) signal: String,
    pub(crate) from: String,
    pub(crate) to: Vec<String>,
}

/// Signals that stay on this side.
pub(crate) fn own_signals(hal: &HalConfig) -> Vec<OwnSignal> {
    let own = |signal: &str, from: &str, to: &str| OwnSignal {
        signal: format!("camwright-{signal}"),
        from: from.to_owned(),
        to: vec![to.to_owned()],
    };
    let gates = gates();
    let orders = gates.iter().map(|(gate, order)| OwnSignal {
        signal: format!("{gate}-order"),
        from: order.clone(),
        to: vec![format!("{gate}.in-0")],
    });
    let silent = OwnSignal {
        signal: format!("{SILENCE}-now"),
        from: format!("{SILENCE}.q"),
        to: gates.iter().map(|(gate, _)| format!("{gate}.in-1")).collect(),
    };
    let fixed = [
        own("sequence", "streamer.0.pin.0", "sampler.0.pin.0"),
        own("queued", "streamer.0.curr-depth", "sampler.0.pin.1"),
        own("inputs", "wsum.0.sum", "sampler.0.pin.5"),
        own("stations", "wsum.1.sum", "sampler.0.pin.6"),
        own("jitter", &format!("{PERIOD}.current-jitter"), "sampler.0.pin.7"),
        own("queue-empty", "streamer.0.empty", &format!("{SILENCE}.in")),
    ];
    let waiting = indexed(hal).map(|axis| OwnSignal {
        signal: signal(&format!("{}.index_enable", axis.joint())),
        from: format!("{}.out", arming(axis)),
        to: vec![word_bit(INDEXES, axis)],
    });
    fixed.into_iter().chain([silent]).chain(orders).chain(waiting).collect()
}

/// Components of HAL that lie on this side: type and names.
pub(crate) fn components(hal: &HalConfig) -> Vec<(&'static str, String)> {
    let gates: Vec<String> = gates().into_iter().map(|(gate, _)| gate).collect();
    let armings: Vec<String> = indexed(hal).map(arming).collect();
    let mut all = vec![("ton", SILENCE.to_owned()), ("lut5", gates.join(",")), ("timedelta", PERIOD.to_owned())];
    if !armings.is_empty() {
        all.push(("tristate_bit", armings.join(",")));
    }
    all
}

/// Parameters of these components.
pub(crate) fn own_parameters(hal: &HalConfig) -> Vec<(String, String)> {
    let gates = gates().into_iter().map(|(gate, _)| (format!("{gate}.function"), GATE.to_owned()));
    let armings = indexed(hal).map(arming);
    let armings = armings.flat_map(|name| ["in", "enable"].map(|pin| (format!("{name}.{pin}"), "1".to_owned())));
    gates.chain([(format!("{SILENCE}.pt"), SILENCE_S.to_string())]).chain(armings).collect()
}

/// Functions of a thread, in their order: before the drives, and after them.
pub(crate) fn functions(hal: &HalConfig) -> [Vec<String>; 2] {
    let gates = gates().into_iter().map(|(gate, _)| gate);
    let before = ["streamer.0", SILENCE].map(str::to_owned).into_iter().chain(gates);
    let before = before.chain(indexed(hal).map(arming)).collect();
    [before, ["process_wsums", PERIOD, "sampler.0"].map(str::to_owned).to_vec()]
}
