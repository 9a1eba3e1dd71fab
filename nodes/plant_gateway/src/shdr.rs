// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Text of SHDR, the protocol between an MTConnect adapter and its agent: one line for each set of changes, one for each condition.
//!
//! Forms and escapes are those of the agent's manual (`README.md` of `mtconnect/cppagent`).

use crate::items::{Category, ITEMS, Reading};
use camwright_msgs::camwright_msgs::msg::Alarm;
use camwright_threads::system_time::utc;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Period in which an agent sends PING (ms). A client that has sent one and is silent for twice this time is disconnected.
pub(super) const HEARTBEAT_MS: u32 = 10_000;

/// Version of the MTConnect model that the device model and the values follow.
pub(super) const MTCONNECT_VERSION: &str = "2.0";

const UNAVAILABLE: &str = "UNAVAILABLE";

/// Commands at the beginning of a connection.
#[must_use]
pub(super) fn greeting() -> String {
    let version = env!("CARGO_PKG_VERSION");
    format!("* adapterVersion: {version}\n* mtconnectVersion: {MTCONNECT_VERSION}\n* shdrVersion: 2\n")
}

/// Answer to PING.
#[must_use]
pub(super) fn pong() -> String {
    format!("* PONG {HEARTBEAT_MS}\n")
}

/// First part of all ids of the cell in a namespace: `cell_2_` for `/cell_2`, nothing for `/`.
#[must_use]
pub(super) fn id_prefix(namespace: &str) -> String {
    let name = namespace.trim_matches('/').replace('/', "_");
    if name.is_empty() { name } else { format!("{name}_") }
}

/// Lines for all values that differ from `before`, or for all values without it; samples only with `with_samples`.
#[must_use]
pub(super) fn changes(
    before: Option<&[Option<Reading>]>,
    now: &[Option<Reading>],
    with_samples: bool,
    prefix: &str,
    time_ns: i64,
) -> String {
    let time = utc(u64::try_from(time_ns).unwrap_or_default());
    let (mut values, mut conditions) = (String::new(), String::new());
    for (index, item) in ITEMS.iter().enumerate() {
        let new = now.get(index).and_then(Option::as_ref);
        let old = before.and_then(|before| before.get(index)?.as_ref());
        // An item that another machine had is not available any more.
        let Some(new) = new.or(old.map(|_| &Reading::Unavailable)) else { continue };
        if old == Some(new) || item.category == Category::Sample && !with_samples {
            continue;
        }
        let key = format!("{prefix}{}", item.id);
        match (new, item.category) {
            (Reading::Unavailable, Category::Condition) => {
                let _infallible = writeln!(conditions, "{time}|{key}|{UNAVAILABLE}||||");
            }
            (Reading::Alarms(alarms), _) => {
                let empty = BTreeMap::new();
                let known = match old {
                    Some(Reading::Alarms(known)) => known,
                    _ => &empty,
                };
                if alarms.is_empty() {
                    let _infallible = writeln!(conditions, "{time}|{key}|NORMAL||||");
                    continue;
                }
                for number in known.keys().filter(|number| !alarms.contains_key(number)) {
                    let _infallible = writeln!(conditions, "{time}|{key}|NORMAL|{number}|||");
                }
                for (number, alarm) in alarms.iter().filter(|(number, alarm)| known.get(number) != Some(alarm)) {
                    let level = if alarm.severity == Alarm::WARNING { "WARNING" } else { "FAULT" };
                    let (severity, text) = (alarm.severity, escaped(&alarm.text));
                    let _infallible = writeln!(conditions, "{time}|{key}|{level}|{number}|{severity}||{text}");
                }
            }
            (Reading::Unavailable, _) => {
                let _infallible = write!(values, "|{key}|{UNAVAILABLE}");
            }
            (Reading::Value(value), _) => {
                let _infallible = write!(values, "|{key}|{}", escaped(value));
            }
        }
    }
    if !values.is_empty() {
        values = format!("{time}{values}\n");
    }
    values + &conditions
}

/// Takes over new values, except those of samples, which clients do not have yet.
pub(super) fn keep_samples(sent: &mut [Option<Reading>], new: Vec<Option<Reading>>) {
    for ((sent, new), item) in sent.iter_mut().zip(new).zip(ITEMS) {
        if item.category != Category::Sample {
            *sent = new;
        }
    }
}

/// Longest text of a field (characters); the rest is cut off.
const MAX_TEXT: usize = 1024;

/// Text as a field: without control characters, and quoted where it contains what ends a field.
fn escaped(text: &str) -> String {
    let plain: String = text.chars().take(MAX_TEXT).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if !plain.contains(['|', '"', '\\']) {
        return plain;
    }
    let mut quoted = String::from("\"");
    for letter in plain.chars() {
        if matches!(letter, '|' | '"' | '\\') {
            quoted.push('\\');
        }
        quoted.push(letter);
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_messages::{CellMessages, Equipment, Presence};
    use crate::items::read_all;
    use camwright_msgs::camwright_msgs::msg::{CellState, MachineAlarms, MachineDescription, MachineIo};

    /// 2026-11-21 03:15:00.123 UTC.
    const TIME_NS: i64 = 1_795_230_900_123_000_000;

    fn alarm(number: u16, severity: u8, source: &str, text: &str) -> Alarm {
        Alarm { number, severity, source: source.into(), text: text.into(), ..Alarm::default() }
    }

    fn cell(alarms: Vec<Alarm>) -> CellMessages {
        CellMessages {
            presence: Presence { machine: true, interpolator: true, planner: true },
            machine_alarms: Some(MachineAlarms { alarms, ..MachineAlarms::default() }),
            ..CellMessages::default()
        }
    }

    /// Changes of the events and conditions from one state of the cell to another.
    fn between(before: &CellMessages, now: &CellMessages) -> String {
        changes(Some(&read_all(before)), &read_all(now), false, "", TIME_NS)
    }

    #[test]
    fn the_first_lines_have_every_item_of_the_machine() {
        let nothing = CellMessages::default();
        let text = changes(None, &read_all(&nothing), true, "", TIME_NS);
        let line = text.lines().next().expect("a line");
        assert!(
            line.starts_with("2026-11-21T03:15:00.123Z|availability|UNAVAILABLE|equipment_timer_powered|UNAVAILABLE|")
        );
        assert!(line.contains("|x_position|UNAVAILABLE|") && !text.contains("door_state"), "{text}");
        let conditions: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(
            conditions,
            ["system", "c_system", "x_system", "z_system"]
                .map(|key| format!("2026-11-21T03:15:00.123Z|{key}|UNAVAILABLE||||"))
        );
        let known = CellMessages { equipment: Equipment { loading: true, ..Equipment::default() }, ..nothing };
        assert!(changes(None, &read_all(&known), true, "", TIME_NS).contains("|door_state|UNAVAILABLE"));
        let prefixed = changes(None, &read_all(&known), true, &id_prefix("/hall/cell_2"), TIME_NS);
        assert!(prefixed.contains("|hall_cell_2_door_state|UNAVAILABLE"), "{prefixed}");
    }

    #[test]
    fn only_changes_are_sent_and_samples_when_asked_for() {
        let before = cell(Vec::new());
        assert_eq!(between(&before, &before), "");
        let with_io = CellMessages { io: Some(MachineIo { estop: true, ..MachineIo::default() }), ..before.clone() };
        let line = "2026-11-21T03:15:00.123Z|emergency_stop|TRIGGERED|part_detect|NOT_PRESENT\n";
        assert_eq!(between(&before, &with_io), line);
        let wheel = Equipment { wheel: true, ..Equipment::default() };
        let description = MachineDescription { wheel_radius: 0.25, wheel_wear: 0.000_01, ..Default::default() };
        let described = CellMessages { description: Some(description), equipment: wheel, ..before.clone() };
        let text = between(&before, &described);
        assert!(text.contains("|s_rotary_mode|SPINDLE") && !text.contains("s_diameter"), "{text}");
        let text = changes(Some(&read_all(&before)), &read_all(&described), true, "", TIME_NS);
        assert!(text.contains("|s_diameter|499.98"), "{text}");
        // Back to a machine without a wheel.
        let text = changes(Some(&read_all(&described)), &read_all(&before), true, "", TIME_NS);
        assert!(text.contains("|s_diameter|UNAVAILABLE") && text.contains("|s_rotary_mode|UNAVAILABLE"), "{text}");
    }

    #[test]
    fn alarms_become_conditions_of_their_component_and_normal_again() {
        let normal = cell(Vec::new());
        let warning = alarm(102, Alarm::WARNING, "machine_sim", "the wheel is worn");
        let fault = alarm(42, Alarm::POWER_OFF, "x_axis", "drive fault");
        let second = alarm(150, Alarm::POWER_OFF, "machine_sim", "door opened");
        let time = "2026-11-21T03:15:00.123Z";
        assert_eq!(between(&CellMessages::default(), &normal).matches("|NORMAL||||\n").count(), 4);
        let two = cell(vec![warning.clone(), fault.clone()]);
        assert_eq!(
            between(&normal, &two),
            format!("{time}|system|WARNING|102|1||the wheel is worn\n{time}|x_system|FAULT|42|3||drive fault\n")
        );
        let three = cell(vec![warning.clone(), fault, second.clone()]);
        assert_eq!(between(&two, &three), format!("{time}|system|FAULT|150|3||door opened\n"));
        // One of two is reset, then the other.
        let one = cell(vec![second]);
        assert_eq!(between(&three, &one), format!("{time}|system|NORMAL|102|||\n{time}|x_system|NORMAL||||\n"));
        assert_eq!(between(&one, &normal), format!("{time}|system|NORMAL||||\n"));
        // The interpolator's alarm of the same number does not hide the more severe one.
        let mut both = cell(vec![alarm(80, Alarm::STOP, "machine_sim", "underrun")]);
        let again = vec![alarm(80, Alarm::WARNING, "axis_interpolator", "late"), warning];
        both.interpolator_alarms = Some(MachineAlarms { alarms: again, ..MachineAlarms::default() });
        let text = between(&normal, &both);
        assert!(text.contains("|system|FAULT|80|2||underrun\n") && text.contains("|system|WARNING|102|"), "{text}");
        // Without the machine nothing is known of alarms.
        let lost = CellMessages { presence: Presence::default(), ..one };
        let text = between(&both, &lost);
        assert!(text.contains("|system|UNAVAILABLE||||\n") && text.contains("|availability|UNAVAILABLE"), "{text}");
    }

    #[test]
    fn a_text_never_ends_its_field_or_its_line() {
        assert_eq!(escaped("pass 2 of 3"), "pass 2 of 3");
        assert_eq!(escaped("a|b"), r#""a\|b""#);
        assert_eq!(escaped(r#"a "b" \c"#), r#""a \"b\" \\c""#);
        assert_eq!(escaped("a\r\nb\tc\u{0}"), "a  b c ");
        assert_eq!(escaped(&"x".repeat(1 << 20)).len(), MAX_TEXT);
        let job = "lobe|1\n2026-01-01T00:00:00Z|execution|READY";
        let state = CellState { job: job.into(), state: CellState::EXECUTE, mode: 1, ..CellState::default() };
        let before = cell(vec![]);
        let now = CellMessages { cell: Some(state), ..before.clone() };
        let text = between(&before, &now);
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(
            text.contains(r#"|execution|ACTIVE|program|"lobe\|1 2026-01-01T00:00:00Z\|execution\|READY""#),
            "{text}"
        );
        let hostile = cell(vec![alarm(1, 1, "machine_sim", "x\" | y\\\n* PONG 1")]);
        let text = between(&before, &hostile);
        assert_eq!(text, "2026-11-21T03:15:00.123Z|system|WARNING|1|1||\"x\\\" \\| y\\\\ * PONG 1\"\n");
    }

    /// Fields of a line as the agent's manual describes them: `|` ends a field, a field in quotes has escapes with a backslash.
    fn fields(line: &str) -> Vec<String> {
        let (mut fields, mut letters) = (vec![String::new()], line.chars().peekable());
        let mut is_quoted = false;
        while let Some(letter) = letters.next() {
            let field = fields.last_mut().expect("a field");
            match letter {
                '"' if field.is_empty() && !is_quoted => is_quoted = true,
                '"' if is_quoted => {
                    assert!(matches!(letters.peek(), None | Some('|')), "text after the closing quote: {line}");
                    is_quoted = false;
                }
                '\\' if is_quoted => field.extend(letters.next()),
                '|' if !is_quoted => fields.push(String::new()),
                '|' => panic!("an open | in quotes: {line}"),
                other => field.push(other),
            }
        }
        fields
    }

    #[test]
    fn an_agent_reads_the_text_that_was_sent() {
        let pieces = ["|", "\"", "\\", "a", "\\|", "\"|\"", "|\\", "ä", ":", "x y"];
        let before = cell(Vec::new());
        for first in pieces {
            for second in pieces {
                for third in pieces {
                    let text = format!("{first}{second}{third}");
                    let alarm = alarm(42, Alarm::STOP, "x_axis", &text);
                    let line = between(&before, &cell(vec![alarm]));
                    let read = fields(line.trim_end_matches('\n'));
                    assert_eq!(read[1..], ["x_system", "FAULT", "42", "2", "", &text], "{line}");
                }
            }
        }
    }

    #[test]
    fn a_client_is_greeted_with_documented_commands() {
        let version = env!("CARGO_PKG_VERSION");
        assert_eq!(greeting(), format!("* adapterVersion: {version}\n* mtconnectVersion: 2.0\n* shdrVersion: 2\n"));
        assert_eq!(pong(), "* PONG 10000\n");
        let prefixes = ["/", "", "/cell_2", "/a/b/"].map(id_prefix);
        assert_eq!(prefixes, ["", "", "cell_2_", "a_b_"]);
    }
}
