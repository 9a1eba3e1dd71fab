// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Inputs as they were applied: as messages, and back from them to the bit.

use crate::convert::machine_report::{input_name, input_named};
use crate::digest;
use crate::record_text::record_text;
use camwright::interpolator::quantity::MotionQuantity;
use camwright::interpolator::tolerance::{MotionPhase, ToleranceViolation};
use camwright::interpolator::{AppliedInput as Applied, MotionRequest};
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::setpoint::Latch;
use camwright_msgs::camwright_msgs::msg::AppliedInput;
use serde::{Deserialize, Serialize};

const QUANTITIES: [MotionQuantity; 4] =
    [MotionQuantity::Position, MotionQuantity::Velocity, MotionQuantity::Acceleration, MotionQuantity::Jerk];

/// A broken tolerance; numbers in the core's units.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BrokenRecord {
    joint: String,
    quantity: String,
    error: f64,
    allowed: f64,
    at_the_goal: bool,
    time_s: f64,
}

/// An input as a message, without its time and its place in the sequence.
pub fn message(input: &Applied, machine: &MachineDescription) -> AppliedInput {
    let plain = |kind: u8| AppliedInput { kind, ..AppliedInput::default() };
    match input {
        Applied::Request(MotionRequest::Hold) => plain(AppliedInput::HOLD),
        Applied::Request(MotionRequest::Unhold) => plain(AppliedInput::UNHOLD),
        Applied::Request(MotionRequest::Cancel) => plain(AppliedInput::CANCEL),
        Applied::Request(MotionRequest::SetOverride(value)) => {
            AppliedInput { value: *value, ..plain(AppliedInput::OVERRIDE) }
        }
        Applied::Request(MotionRequest::Decision) => plain(AppliedInput::DECISION),
        Applied::Feedback(latch) => AppliedInput {
            text: input_name(latch.input, machine).to_owned(),
            counts: latch.counts,
            value: f64::from(u8::from(latch.rising)),
            source_tick: latch.tick,
            ..plain(AppliedInput::FEEDBACK)
        },
        Applied::OutOfTolerance(broken) => {
            let record = BrokenRecord {
                joint: broken.axis.joint().to_owned(),
                quantity: broken.quantity.to_string(),
                error: broken.error,
                allowed: broken.allowed,
                at_the_goal: broken.stretch == MotionPhase::Goal,
                time_s: broken.time_s,
            };
            AppliedInput { text: broken.to_string(), content: record_text(&record), ..plain(AppliedInput::TOLERANCE) }
        }
        Applied::Settled => plain(AppliedInput::SETTLED),
        Applied::Alarm(number) => AppliedInput { counts: i64::from(*number), ..plain(AppliedInput::ALARM) },
    }
}

/// Input of a message; `None` if it begins a motion.
///
/// # Errors
/// The message contains no input.
pub fn input(message: &AppliedInput, machine: &MachineDescription) -> Result<Option<Applied>, String> {
    let request = |request| Ok(Some(Applied::Request(request)));
    match message.kind {
        AppliedInput::START | AppliedInput::SPLICE => Ok(None),
        AppliedInput::HOLD => request(MotionRequest::Hold),
        AppliedInput::UNHOLD => request(MotionRequest::Unhold),
        AppliedInput::CANCEL => request(MotionRequest::Cancel),
        AppliedInput::OVERRIDE => request(MotionRequest::SetOverride(message.value)),
        AppliedInput::DECISION => request(MotionRequest::Decision),
        AppliedInput::FEEDBACK => {
            let input = input_named(&message.text, machine)
                .ok_or_else(|| format!("the machine has no input {:?}", message.text))?;
            let (tick, counts) = (message.source_tick, message.counts);
            Ok(Some(Applied::Feedback(Latch { tick, input, rising: message.value > 0.5, axis: input.axis(), counts })))
        }
        AppliedInput::ALARM => {
            let number = u16::try_from(message.counts).map_err(|_| format!("there is no alarm {}", message.counts))?;
            Ok(Some(Applied::Alarm(number)))
        }
        AppliedInput::TOLERANCE => Ok(Some(Applied::OutOfTolerance(broken(&message.content)?))),
        AppliedInput::SETTLED => Ok(Some(Applied::Settled)),
        kind => Err(format!("there is no input of kind {kind}")),
    }
}

fn broken(content: &str) -> Result<ToleranceViolation, String> {
    let record: BrokenRecord = serde_json::from_str(content).map_err(|error| error.to_string())?;
    let axis = Axis::from_joint(&record.joint).ok_or_else(|| format!("there is no joint {:?}", record.joint))?;
    let quantity = QUANTITIES.into_iter().find(|quantity| quantity.to_string() == record.quantity);
    let quantity = quantity.ok_or_else(|| format!("{:?} is no quantity", record.quantity))?;
    let stretch = if record.at_the_goal { MotionPhase::Goal } else { MotionPhase::Path };
    let BrokenRecord { error, allowed, time_s, .. } = record;
    Ok(ToleranceViolation { axis, quantity, error, allowed, stretch, time_s })
}

/// The digest by which a message is known to be as it was made.
///
/// # Errors
/// A message that CDR cannot carry.
pub fn check(message: &AppliedInput) -> Result<u64, String> {
    digest::message_digest(&AppliedInput { check: 0, ..message.clone() })
}

/// Name of a kind of input in messages.
pub fn kind_name(kind: u8) -> &'static str {
    match kind {
        AppliedInput::START => "START",
        AppliedInput::HOLD => "HOLD",
        AppliedInput::UNHOLD => "UNHOLD",
        AppliedInput::CANCEL => "CANCEL",
        AppliedInput::OVERRIDE => "OVERRIDE",
        AppliedInput::DECISION => "DECISION",
        AppliedInput::FEEDBACK => "FEEDBACK",
        AppliedInput::ALARM => "ALARM",
        AppliedInput::TOLERANCE => "TOLERANCE",
        AppliedInput::SETTLED => "SETTLED",
        AppliedInput::SPLICE => "SPLICE",
        _ => "an unknown input",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::machine::reference::cam_grinder;
    use camwright::machine::setpoint::Input;

    #[test]
    fn every_input_comes_back_from_its_message_to_the_bit() {
        let machine = cam_grinder();
        let latch = |input: Input, rising| Latch { tick: 77, input, rising, axis: input.axis(), counts: -123_456_789 };
        let broken = ToleranceViolation {
            axis: Axis::X,
            quantity: MotionQuantity::Velocity,
            error: -0.1 - f64::EPSILON,
            allowed: 1.0 / 3.0,
            stretch: MotionPhase::Goal,
            time_s: 5e-324,
        };
        let inputs = [
            Applied::Request(MotionRequest::Hold),
            Applied::Request(MotionRequest::Unhold),
            Applied::Request(MotionRequest::Cancel),
            Applied::Request(MotionRequest::SetOverride(0.1 + 0.2)),
            Applied::Request(MotionRequest::Decision),
            Applied::Feedback(latch(Input::Station(2), true)),
            Applied::Feedback(latch(Input::Home(Axis::Z), false)),
            Applied::Feedback(latch(Input::SteadyForce, true)),
            Applied::Feedback(latch(Input::SizeReached, true)),
            Applied::OutOfTolerance(broken),
            Applied::Settled,
            Applied::Alarm(140),
        ];
        for applied in inputs {
            assert_eq!(input(&message(&applied, &machine), &machine), Ok(Some(applied)));
        }
        let nothing = AppliedInput { kind: 99, ..AppliedInput::default() };
        assert!(input(&nothing, &machine).is_err());
    }

    #[test]
    fn a_changed_message_is_known_by_its_check() {
        let message = AppliedInput { tick: 5, value: 0.5, text: "origin".into(), ..AppliedInput::default() };
        let reference = check(&message).expect("it travels");
        let changed = AppliedInput { value: f64::from_bits(message.value.to_bits() ^ 1), ..message.clone() };
        assert_ne!(check(&changed), Ok(reference));
        assert_eq!(check(&AppliedInput { check: 7, ..message }), Ok(reference), "its own check does not count");
    }
}
