//! Orders to the machine as messages, and back.

use super::pump::{input_name, input_named};
use super::traffic::{Order, TimedCommand};
use camwright::machine::MachineCommand;
use camwright::machine::description::{Axis, MachineDescription};
use camwright_msgs::camwright_msgs::msg::MachineCommand as CommandMessage;

/// The command that a message is; `None`: it is none that this machine knows.
pub(super) fn timed(message: &CommandMessage, machine: &MachineDescription) -> Option<TimedCommand> {
    let order = order(message, machine)?;
    Some(TimedCommand { sequence: message.sequence, tick: message.tick, order })
}

fn order(message: &CommandMessage, machine: &MachineDescription) -> Option<Order> {
    let counts = message.counts;
    let axis = || Axis::from_joint(&message.target);
    Some(Order::Machine(match message.kind {
        CommandMessage::SET_HOME => MachineCommand::SetHome { axis: axis()?, counts },
        CommandMessage::LOSE_HOME => MachineCommand::LoseHome { axis: axis()? },
        CommandMessage::ASK => MachineCommand::Ask { input: input_named(&message.target, machine)? },
        CommandMessage::WHEEL_START => MachineCommand::WheelStart,
        CommandMessage::WHEEL_STOP => MachineCommand::WheelStop,
        CommandMessage::EXPECT_WHEEL => MachineCommand::ExpectWheel { radius_nm: counts },
        CommandMessage::DRESS => MachineCommand::Dress { radius_nm: counts },
        CommandMessage::PUSH => MachineCommand::Push { most_n: counts },
        CommandMessage::WATCH_FORCE => MachineCommand::WatchForce { most_n: counts },
        CommandMessage::ALARM => MachineCommand::Raise { number: u16::try_from(counts).ok()? },
        CommandMessage::JOB_BEGIN => return Some(Order::JobBegin),
        CommandMessage::JOB_END => return Some(Order::JobEnd),
        CommandMessage::ATTEND => return Some(Order::Attend),
        _ => return None,
    }))
}

/// A command as the message that it was, without its stamp.
pub(super) fn message(command: &TimedCommand, machine: &MachineDescription) -> CommandMessage {
    let joint = |axis: Axis| axis.joint().to_owned();
    let (kind, target, counts) = match command.order {
        Order::JobBegin => (CommandMessage::JOB_BEGIN, String::new(), 0),
        Order::JobEnd => (CommandMessage::JOB_END, String::new(), 0),
        Order::Attend => (CommandMessage::ATTEND, String::new(), 0),
        Order::Machine(order) => match order {
            MachineCommand::SetHome { axis, counts } => (CommandMessage::SET_HOME, joint(axis), counts),
            MachineCommand::LoseHome { axis } => (CommandMessage::LOSE_HOME, joint(axis), 0),
            MachineCommand::Ask { input } => (CommandMessage::ASK, input_name(input, machine).to_owned(), 0),
            MachineCommand::WheelStart => (CommandMessage::WHEEL_START, String::new(), 0),
            MachineCommand::WheelStop => (CommandMessage::WHEEL_STOP, String::new(), 0),
            MachineCommand::ExpectWheel { radius_nm } => (CommandMessage::EXPECT_WHEEL, String::new(), radius_nm),
            MachineCommand::Dress { radius_nm } => (CommandMessage::DRESS, String::new(), radius_nm),
            MachineCommand::Push { most_n } => (CommandMessage::PUSH, String::new(), most_n),
            MachineCommand::WatchForce { most_n } => (CommandMessage::WATCH_FORCE, String::new(), most_n),
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
    use camwright::setpoint::Input;

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
            MachineCommand::Dress { radius_nm: 59_980_000 },
            MachineCommand::Push { most_n: 30 },
            MachineCommand::WatchForce { most_n: 2 },
            MachineCommand::Raise { number: 301 },
        ];
        let orders = orders.map(Order::Machine).into_iter().chain([Order::JobBegin, Order::JobEnd, Order::Attend]);
        for (sequence, order) in (1..).zip(orders) {
            let command = TimedCommand { sequence, tick: 1000, order };
            assert_eq!(timed(&message(&command, &machine), &machine), Some(command));
        }
        assert_eq!(timed(&CommandMessage { kind: 99, ..CommandMessage::default() }, &machine), None);
    }
}
