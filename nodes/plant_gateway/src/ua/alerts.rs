// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Alerts: an event when an alarm becomes active, and one when it is reset.

use super::nodes::severity;
use camwright_msgs::camwright_msgs::msg::Alarm;
use opcua::nodes::{BaseEventType, Event};
use opcua::types::event_field::EventField;
use opcua::types::{AttributeId, ByteString, DateTime, LocalizedText, NodeId, NumericRange, QualifiedName, Variant};

/// An alarm that became active or was reset.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AlarmChange {
    pub(super) alarm: Alarm,
    pub(super) is_active: bool,
}

/// Changes between two lists of active alarms, resets first. An alarm is known by its number and its source.
#[must_use]
pub(super) fn alarm_changes(before: &[Alarm], now: &[&Alarm]) -> Vec<AlarmChange> {
    let is_same = |one: &Alarm, other: &Alarm| one.number == other.number && one.source == other.source;
    let reset = before.iter().filter(|old| !now.iter().any(|new| is_same(old, new)));
    let raised = now.iter().filter(|new| !before.iter().any(|old| is_same(old, new)));
    let resets = reset.map(|alarm| AlarmChange { alarm: alarm.clone(), is_active: false });
    resets.chain(raised.map(|alarm| AlarmChange { alarm: (*alarm).clone(), is_active: true })).collect()
}

/// An event of `AlertType` with the fields that the cell knows.
#[derive(Debug)]
pub(super) struct AlertEvent {
    base: BaseEventType,
    change: AlarmChange,
}

impl AlertEvent {
    /// Event of a change at a time. `number` makes its identifier unique in this server.
    #[must_use]
    pub(super) fn new(change: AlarmChange, (alert, source): (NodeId, NodeId), time: DateTime, number: u64) -> Self {
        let id = [i64::from(time).to_be_bytes(), number.to_be_bytes()].concat();
        let text = LocalizedText::new("en", &change.alarm.text);
        let base = BaseEventType::new(alert, ByteString::from(id), text, time)
            .set_source_node(source)
            .set_source_name(change.alarm.source.as_str().into())
            .set_severity(severity(change.alarm.severity));
        Self { base, change }
    }
}

impl EventField for AlertEvent {
    fn get_value(&self, attribute_id: AttributeId, range: &NumericRange, path: &[QualifiedName]) -> Variant {
        let names: Vec<&str> = path.iter().map(|name| name.name.as_ref()).collect();
        let is_active = self.change.is_active;
        match names[..] {
            _ if attribute_id != AttributeId::Value => Variant::Empty,
            ["ErrorCode" | "ConditionName"] => self.change.alarm.number.to_string().into(),
            ["Retain"] | ["ActiveState", "Id"] => is_active.into(),
            ["EnabledState", "Id"] => true.into(),
            ["ActiveState"] => LocalizedText::new("en", if is_active { "Active" } else { "Inactive" }).into(),
            ["EnabledState"] => LocalizedText::new("en", "Enabled").into(),
            _ => self.base.get_value(attribute_id, range, path),
        }
    }
}

impl Event for AlertEvent {
    fn get_field(
        &self,
        _type_definition_id: &NodeId,
        attribute_id: AttributeId,
        index_range: &NumericRange,
        browse_path: &[QualifiedName],
    ) -> Variant {
        self.get_value(attribute_id, index_range, browse_path)
    }

    fn time(&self) -> &DateTime {
        &self.base.time
    }

    fn event_type_id(&self) -> &NodeId {
        &self.base.event_type
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarm(number: u16, severity: u8, source: &str) -> Alarm {
        Alarm { number, severity, source: source.into(), text: format!("alarm {number}"), ..Alarm::default() }
    }

    #[test]
    fn an_alarm_is_raised_once_and_reset_once() {
        let (worn, door) = (alarm(102, Alarm::WARNING, "machine_sim"), alarm(150, Alarm::POWER_OFF, "machine_sim"));
        let raised = alarm_changes(&[], &[&worn, &door]);
        assert!(raised.iter().all(|change| change.is_active) && raised.len() == 2, "{raised:?}");
        assert_eq!(alarm_changes(&[worn.clone(), door.clone()], &[&worn, &door]), []);
        let next = alarm(102, Alarm::WARNING, "axis_interpolator");
        let changes = alarm_changes(&[worn.clone(), door.clone()], &[&door, &next]);
        let expected = [AlarmChange { alarm: worn, is_active: false }, AlarmChange { alarm: next, is_active: true }];
        assert_eq!(changes, expected, "the same number of another source is another alarm");
    }

    #[test]
    fn an_alert_has_number_text_and_state() {
        let change = AlarmChange { alarm: alarm(42, Alarm::STOP, "x_axis"), is_active: true };
        let ids = (NodeId::new(3, 39), NodeId::new(4, "Notification/Messages"));
        let event = AlertEvent::new(change, ids.clone(), DateTime::from(133_000_000_000_000_000), 7);
        let field = |path: &[&str]| {
            let path: Vec<QualifiedName> = path.iter().map(|name| (*name).into()).collect();
            event.get_field(&ids.0, AttributeId::Value, &NumericRange::None, &path)
        };
        assert_eq!(field(&["ErrorCode"]), "42".into());
        assert_eq!(field(&["Message"]), LocalizedText::new("en", "alarm 42").into());
        assert_eq!(field(&["Severity"]), 700_u16.into());
        assert_eq!(field(&["SourceName"]), "x_axis".into());
        assert_eq!(field(&["EventType"]), ids.0.clone().into());
        assert_eq!(field(&["ActiveState", "Id"]), true.into());
        assert_eq!(field(&["AckedState"]), Variant::Empty, "the cell knows no acknowledgement");
        assert_eq!([Alarm::WARNING, Alarm::STOP, Alarm::POWER_OFF].map(severity), [500, 700, 900]);
    }
}
