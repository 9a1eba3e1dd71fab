// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Orders to the machine as messages, and back.

use super::messages::{MachineOrder, TimedCommand};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, AxisScale, MAX_WHEELS, MachineDescription};
use camwright::simulation::MachineCommand;
use camwright_files::convert::machine_report::{input_name, input_named};
use camwright_files::convert::time::TickClock;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::MachineCommand as CommandMessage;

/// Feedback delays that a command may lie ahead: setpoints go one ahead, and an order takes effect two after the setpoint that issues it.
const MAX_DELAYS_AHEAD: u64 = 3;
/// Ticks that the machine's last tick, as this check knows it, may be behind the tick that the sender has seen.
const MAX_BEHIND: u64 = 1000;
/// Largest reading of a rotary axis that becomes its zero (turns).
const MAX_TURNS: i64 = 1_000_000;
/// Largest radius of a wheel (nm).
const MAX_RADIUS_NM: i64 = 1_000_000_000;
/// Largest diameter on a gauge (nm).
const MAX_DIAMETER_NM: i64 = 2 * MAX_RADIUS_NM;
/// Longest target: the hash of a plan, or the name of an input.
const MAX_TARGET: usize = 64;

/// The command that a message is, once every field is in its bounds; `executed` is the machine's last tick.
///
/// # Errors
/// The field that is not, its value, and what is allowed.
pub fn checked(
    message: &CommandMessage,
    machine: &MachineDescription,
    clock: TickClock,
    executed: u64,
) -> Result<TimedCommand, String> {
    let CommandMessage { kind, target, counts, tick, .. } = message;
    let of = |what: String| format!("command of kind {kind}: {what}; correct the sender");
    if target.len() > MAX_TARGET {
        return Err(of(format!("target has {} octets; allowed: {MAX_TARGET}", target.len())));
    }
    let command = timed(message, machine)
        .ok_or_else(|| of(format!("no such order with target {target:?} and counts {counts} is known")))?;
    if let MachineOrder::Machine(MachineCommand::Raise { number }) = command.order
        && AlarmKind::from_number(number).is_none()
    {
        return Err(of(format!("counts is {counts}, which is the number of no alarm")));
    }
    let ahead = MAX_DELAYS_AHEAD * u64::from(machine.feedback_delay_ticks) + MAX_BEHIND;
    let latest = executed.saturating_add(ahead);
    // An announcement takes effect at once.
    if *kind != CommandMessage::ATTEND && *tick > latest {
        return Err(of(format!("tick {tick} is too far ahead; allowed: up to {latest}")));
    }
    if message.stamp != Time::default() && *tick <= latest && message.stamp != clock.stamp(*tick) {
        let Time { sec, nanosec } = message.stamp;
        return Err(of(format!("stamp {sec}.{nanosec:09} is not the time of tick {tick}")));
    }
    let (low, high) = count_bounds(message, machine);
    if !(low..=high).contains(counts) {
        return Err(of(format!("counts is {counts}; allowed: {low} to {high}")));
    }
    Ok(command)
}

/// Range of the counts of a command.
fn count_bounds(message: &CommandMessage, machine: &MachineDescription) -> (i64, i64) {
    #[allow(clippy::cast_possible_truncation, reason = "forces of machines are far below 2^63 N")]
    let force_n = || machine.axis(Axis::X).maximum_force().ceil() as i64;
    match message.kind {
        CommandMessage::SET_HOME => {
            let reach = Axis::from_joint(&message.target).map_or(0, |axis| reach_counts(machine, axis));
            (-reach, reach)
        }
        CommandMessage::EXPECT_WHEEL | CommandMessage::DRESS => (1, MAX_RADIUS_NM),
        // The machine answers the order of a wheel that it does not have with an alarm.
        CommandMessage::CHANGE_WHEEL => (0, MAX_WHEELS as i64 - 1),
        CommandMessage::PUSH | CommandMessage::WATCH_FORCE => (0, force_n()),
        CommandMessage::WATCH_SIZE => (0, MAX_DIAMETER_NM),
        CommandMessage::ALARM => (1, i64::from(u16::MAX)),
        _ => (0, 0),
    }
}

/// Farthest reading of an axis from its zero, wherever it was switched on (counts).
fn reach_counts(machine: &MachineDescription, axis: Axis) -> i64 {
    let own = machine.axis(axis);
    let (low, high) = own.soft_limits.unwrap_or((0.0, 0.0));
    match own.scale {
        AxisScale::Rotary { counts_per_turn } => counts_per_turn.saturating_mul(MAX_TURNS),
        // Twice the travel: hard limits lie beyond the soft ones.
        scale @ AxisScale::Linear { .. } => 2 * scale.counts(high - low).abs().max(scale.counts(high).abs()),
    }
}

/// The command that a message is; `None`: it is none that this machine knows.
pub fn timed(message: &CommandMessage, machine: &MachineDescription) -> Option<TimedCommand> {
    let order = order(message, machine)?;
    Some(TimedCommand { sequence: message.sequence, tick: message.tick, order })
}

fn order(message: &CommandMessage, machine: &MachineDescription) -> Option<MachineOrder> {
    let counts = message.counts;
    let axis = || Axis::from_joint(&message.target);
    Some(MachineOrder::Machine(match message.kind {
        CommandMessage::SET_HOME => MachineCommand::SetHome { axis: axis()?, counts },
        CommandMessage::LOSE_HOME => MachineCommand::LoseHome { axis: axis()? },
        CommandMessage::ASK => MachineCommand::Ask { input: input_named(&message.target, machine)? },
        CommandMessage::WHEEL_START => MachineCommand::WheelStart,
        CommandMessage::WHEEL_STOP => MachineCommand::WheelStop,
        CommandMessage::EXPECT_WHEEL => MachineCommand::ExpectWheel { radius_nm: counts },
        CommandMessage::CHANGE_WHEEL => MachineCommand::ChangeWheel { wheel: u32::try_from(counts).ok()? },
        CommandMessage::DRESS => MachineCommand::Dress { radius_nm: counts },
        CommandMessage::PUSH => MachineCommand::Push { max_n: counts },
        CommandMessage::WATCH_FORCE => MachineCommand::WatchForce { max_n: counts },
        CommandMessage::WATCH_SIZE => MachineCommand::WatchSize { diameter_nm: counts },
        CommandMessage::ALARM => MachineCommand::Raise { number: u16::try_from(counts).ok()? },
        CommandMessage::JOB_BEGIN => return Some(MachineOrder::JobBegin),
        CommandMessage::JOB_END => return Some(MachineOrder::JobEnd),
        CommandMessage::ATTEND => return Some(MachineOrder::Attend),
        _ => return None,
    }))
}

/// A command as the message that it was, without its stamp.
pub fn message(command: &TimedCommand, machine: &MachineDescription) -> CommandMessage {
    let joint = |axis: Axis| axis.joint().to_owned();
    let (kind, target, counts) = match command.order {
        MachineOrder::JobBegin => (CommandMessage::JOB_BEGIN, String::new(), 0),
        MachineOrder::JobEnd => (CommandMessage::JOB_END, String::new(), 0),
        MachineOrder::Attend => (CommandMessage::ATTEND, String::new(), 0),
        MachineOrder::Machine(order) => match order {
            MachineCommand::SetHome { axis, counts } => (CommandMessage::SET_HOME, joint(axis), counts),
            MachineCommand::LoseHome { axis } => (CommandMessage::LOSE_HOME, joint(axis), 0),
            MachineCommand::Ask { input } => (CommandMessage::ASK, input_name(input, machine).to_owned(), 0),
            MachineCommand::WheelStart => (CommandMessage::WHEEL_START, String::new(), 0),
            MachineCommand::WheelStop => (CommandMessage::WHEEL_STOP, String::new(), 0),
            MachineCommand::ExpectWheel { radius_nm } => (CommandMessage::EXPECT_WHEEL, String::new(), radius_nm),
            MachineCommand::ChangeWheel { wheel } => (CommandMessage::CHANGE_WHEEL, String::new(), i64::from(wheel)),
            MachineCommand::Dress { radius_nm } => (CommandMessage::DRESS, String::new(), radius_nm),
            MachineCommand::Push { max_n } => (CommandMessage::PUSH, String::new(), max_n),
            MachineCommand::WatchForce { max_n } => (CommandMessage::WATCH_FORCE, String::new(), max_n),
            MachineCommand::WatchSize { diameter_nm } => (CommandMessage::WATCH_SIZE, String::new(), diameter_nm),
            MachineCommand::Raise { number } => (CommandMessage::ALARM, String::new(), i64::from(number)),
        },
    };
    let (sequence, tick) = (command.sequence, command.tick);
    CommandMessage { sequence, tick, kind, target, counts, ..CommandMessage::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::machine::reference::cam_grinder;
    use camwright::machine::setpoint::Input;

    #[test]
    fn every_order_comes_back_from_its_message() {
        let machine = cam_grinder();
        let orders = [
            MachineCommand::SetHome { axis: Axis::X, counts: -77 },
            MachineCommand::LoseHome { axis: Axis::Z },
            MachineCommand::Ask { input: Input::Station(1) },
            MachineCommand::WheelStart,
            MachineCommand::WheelStop,
            MachineCommand::ExpectWheel { radius_nm: 60_000_000 },
            MachineCommand::ChangeWheel { wheel: 1 },
            MachineCommand::Dress { radius_nm: 59_980_000 },
            MachineCommand::Push { max_n: 30 },
            MachineCommand::WatchForce { max_n: 2 },
            MachineCommand::WatchSize { diameter_nm: 40_012_000 },
            MachineCommand::Raise { number: 301 },
        ];
        let orders = orders.map(MachineOrder::Machine).into_iter().chain([
            MachineOrder::JobBegin,
            MachineOrder::JobEnd,
            MachineOrder::Attend,
        ]);
        for (sequence, order) in (1..).zip(orders) {
            let command = TimedCommand { sequence, tick: 1000, order };
            assert_eq!(timed(&message(&command, &machine), &machine), Some(command));
        }
        assert_eq!(timed(&CommandMessage { kind: 99, ..CommandMessage::default() }, &machine), None);
    }

    #[test]
    fn a_field_out_of_bounds_is_refused_and_named() {
        let machine = cam_grinder();
        let clock = TickClock { epoch_ns: 0, cycle_time_ns: machine.cycle_time_ns };
        let command = |kind, target: &str, counts| CommandMessage {
            sequence: 1,
            tick: 105,
            kind,
            target: target.to_owned(),
            counts,
            ..CommandMessage::default()
        };
        let check = |message: &CommandMessage| checked(message, &machine, clock, 100);
        let home = command(CommandMessage::SET_HOME, "x_axis", 2000);
        assert!(check(&home).is_ok());
        assert!(check(&CommandMessage { stamp: clock.stamp(105), ..home.clone() }).is_ok());
        for (wrong, named) in [
            (CommandMessage { tick: 30_100, ..home.clone() }, "tick 30100"),
            (CommandMessage { stamp: clock.stamp(106), ..home.clone() }, "stamp"),
            (CommandMessage { counts: i64::MAX, ..home.clone() }, "counts"),
            (CommandMessage { counts: i64::MIN, ..home.clone() }, "counts"),
            (command(CommandMessage::SET_HOME, "w_axis", 0), "w_axis"),
            (command(CommandMessage::PUSH, "", i64::MAX), "counts"),
            (command(CommandMessage::PUSH, "", -1), "counts"),
            (command(CommandMessage::WATCH_FORCE, "", i64::MAX), "counts"),
            (command(CommandMessage::WATCH_SIZE, "", i64::MAX), "counts"),
            (command(CommandMessage::EXPECT_WHEEL, "", 0), "counts"),
            (command(CommandMessage::DRESS, "", -1), "counts"),
            (command(CommandMessage::CHANGE_WHEEL, "", -1), "counts"),
            (command(CommandMessage::CHANGE_WHEEL, "", 4), "counts is 4; allowed: 0 to 3"),
            (command(CommandMessage::ALARM, "", 9999), "9999"),
            (command(CommandMessage::JOB_BEGIN, &"x".repeat(65), 0), "target"),
            (command(CommandMessage::WHEEL_START, "", 1), "counts"),
            (command(99, "", 0), "kind 99"),
        ] {
            let reason = check(&wrong).unwrap_err();
            assert!(reason.contains(named), "{wrong:?}: {reason}");
        }
        assert!(check(&command(CommandMessage::PUSH, "", 30)).is_ok());
        assert!(check(&command(CommandMessage::CHANGE_WHEEL, "", 1)).is_ok());
        assert!(check(&command(CommandMessage::JOB_BEGIN, &"a".repeat(64), 0)).is_ok());
        // An order of the last setpoint within the credit of a machine with the largest delay.
        let far = MachineDescription { feedback_delay_ticks: 1000, ..machine.clone() };
        assert!(checked(&CommandMessage { tick: 3_100, ..home.clone() }, &far, clock, 100).is_ok());
        assert!(checked(&CommandMessage { tick: 4_101, ..home }, &far, clock, 100).is_err());
    }
}
