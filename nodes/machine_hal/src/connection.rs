//! Signals between the pins of a machine and the columns of `streamer` and `sampler`.

use camwright::machine::description::{AXIS_COUNT, Axis};
use camwright_files::hal_file::HalConfig;

/// Columns of the streamer: sequence number; C, X, Z; drive of C, X, Z on; wheel runs; speed of the wheel.
pub(crate) const STREAMER_COLUMNS: &str = "ufffbbbbf";
/// Columns of the sampler: sequence number; queued setpoints; C, X, Z; inputs of the machine; switches of the stations.
pub(crate) const SAMPLER_COLUMNS: &str = "usfffss";
/// Samples that wait for this program: ten seconds at 1 kHz.
pub(crate) const SAMPLER_DEPTH: u32 = 10_000;

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
            link(key("enable"), pin, PinType::Bit, true, format!("streamer.0.pin.{}", 1 + AXIS_COUNT + index));
        }
        for (name, pin, first) in
            [("fault", &pins.fault, FAULTS), ("home", &pins.home, HOMES), ("limit", &pins.limit, LIMITS)]
        {
            if let Some(pin) = pin {
                link(key(name), pin, PinType::Bit, false, wired(bit(first)));
            }
        }
    }
    link("hal.wheel.run".to_owned(), &hal.wheel_run, PinType::Bit, true, "streamer.0.pin.7".to_owned());
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

/// Signals that stay on this side: signal, the pin that writes it, the pin that reads it.
pub(crate) const OWN_SIGNALS: [(&str, &str, &str); 4] = [
    ("camwright-sequence", "streamer.0.pin.0", "sampler.0.pin.0"),
    ("camwright-queued", "streamer.0.curr-depth", "sampler.0.pin.1"),
    ("camwright-inputs", "wsum.0.sum", "sampler.0.pin.5"),
    ("camwright-stations", "wsum.1.sum", "sampler.0.pin.6"),
];
