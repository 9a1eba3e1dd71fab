//! Signals between the pins of a machine and the columns of `streamer` and `sampler`.

use camwright::machine::description::{AXIS_COUNT, Axis};
use camwright_files::hal_file::HalConfig;

/// Columns of the streamer: sequence number; C, X, Z; drive of C, X, Z on; wheel runs; speed of the wheel.
pub(crate) const STREAMER_COLUMNS: &str = "ufffbbbbf";
/// Columns of the sampler: sequence number; queued setpoints; C, X, Z; inputs of the machine; switches of the stations; error of the
/// period (ns).
pub(crate) const SAMPLER_COLUMNS: &str = "usfffsss";
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

/// A pin of the machine on a signal with a pin of this side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PinLink {
    /// Key of the machine file.
    pub(crate) key: String,
    pub(crate) pin: String,
    pub(crate) kind: PinType,
    /// The machine reads this pin; otherwise it writes it.
    pub(crate) is_input: bool,
    pub(crate) signal: String,
    /// Pin of `streamer`, `sampler` or `wsum`.
    pub(crate) ours: String,
}

/// Links of a machine.
pub(crate) fn links(hal: &HalConfig) -> Vec<PinLink> {
    let mut links = Vec::new();
    let mut link = |key: String, pin: &str, kind, is_input, ours: String| {
        let signal = format!("camwright-{}", key.trim_start_matches("hal.").replace(['.', '_'], "-"));
        links.push(PinLink { key, pin: pin.to_owned(), kind, is_input, signal, ours });
    };
    let wired = |bit: u32| format!("wsum.0.bit.{bit}.in");
    for (axis, pins) in Axis::ALL.into_iter().zip(&hal.axes) {
        let (name, index) = (axis.joint(), axis.index());
        let key = |key: &str| format!("hal.{name}.{key}");
        let bit = |first: u32| first + u32::try_from(index).unwrap_or(0);
        link(key("command"), &pins.command, PinType::Float, true, format!("streamer.0.pin.{}", 1 + index));
        link(key("feedback"), &pins.feedback, PinType::Float, false, format!("sampler.0.pin.{}", 2 + index));
        if let Some(pin) = &pins.enable {
            link(key("enable"), pin, PinType::Bit, true, format!("{}.out", gate(name)));
        }
        for (name, pin, first) in
            [("fault", &pins.fault, FAULTS), ("home", &pins.home, HOMES), ("limit", &pins.limit, LIMITS)]
        {
            if let Some(pin) = pin {
                link(key(name), pin, PinType::Bit, false, wired(bit(first)));
            }
        }
    }
    link("hal.wheel.run".to_owned(), &hal.wheel_run, PinType::Bit, true, format!("{}.out", gate("wheel")));
    if let Some(pin) = &hal.wheel_speed_rpm {
        link("hal.wheel.speed_rpm".to_owned(), pin, PinType::Float, true, "streamer.0.pin.8".to_owned());
    }
    link("hal.wheel.at_speed".to_owned(), &hal.wheel_at_speed, PinType::Bit, false, wired(AT_SPEED));
    link("hal.estop".to_owned(), &hal.estop, PinType::Bit, false, wired(ESTOP));
    link("hal.origin".to_owned(), &hal.origin, PinType::Bit, false, wired(ORIGIN));
    for (index, (switch, pin)) in hal.stations.iter().enumerate() {
        link(format!("hal.stations.{switch}"), pin, PinType::Bit, false, format!("wsum.1.bit.{index}.in"));
    }
    links
}

/// Component of HAL that switches a drive, or the wheel, on as ordered, while setpoints come.
fn gate(of: &str) -> String {
    format!("camwright-{}-on", of.replace('_', "-"))
}

/// The gates of a machine: component, and the pin of the order.
pub(crate) fn gates(hal: &HalConfig) -> Vec<(String, String)> {
    let with_enable = Axis::ALL.into_iter().filter(|axis| hal.axes[axis.index()].enable.is_some());
    let of_axes = with_enable.map(|axis| (axis.joint(), 1 + AXIS_COUNT + axis.index()));
    of_axes.chain([("wheel", 7)]).map(|(of, pin)| (gate(of), format!("streamer.0.pin.{pin}"))).collect()
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
    let gates = gates(hal);
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
    fixed.into_iter().chain([silent]).chain(orders).collect()
}

/// Components of HAL that lie on this side: type and names.
pub(crate) fn components(hal: &HalConfig) -> [(&'static str, String); 3] {
    let names: Vec<String> = gates(hal).into_iter().map(|(gate, _)| gate).collect();
    [("ton", SILENCE.to_owned()), ("lut5", names.join(",")), ("timedelta", PERIOD.to_owned())]
}

/// Parameters of these components.
pub(crate) fn own_parameters(hal: &HalConfig) -> Vec<(String, String)> {
    let gates = gates(hal).into_iter().map(|(gate, _)| (format!("{gate}.function"), GATE.to_owned()));
    gates.chain([(format!("{SILENCE}.pt"), SILENCE_S.to_string())]).collect()
}

/// Functions of a thread, in their order: before the drives, and after them.
pub(crate) fn functions(hal: &HalConfig) -> [Vec<String>; 2] {
    let gates = gates(hal).into_iter().map(|(gate, _)| gate);
    let before = ["streamer.0", SILENCE].map(str::to_owned).into_iter().chain(gates).collect();
    [before, ["process_wsums", PERIOD, "sampler.0"].map(str::to_owned).to_vec()]
}
