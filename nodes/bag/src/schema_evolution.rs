// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages that were recorded when their type was another: lists and texts that came to its end since are empty, and a time that became a header
//! has no frame.

use super::Topic;
use super::definition::{Field, FieldKind, TypeDefinition};
use camwright_msgs::syntax::{Multiplicity, Primitive};

/// CDR header of a message, in bytes.
const CDR_HEADER: usize = 4;
/// A time in CDR, in bytes.
const TIME: usize = 8;
/// An empty text in CDR, padded to the alignment of the next field.
const NO_FRAME: [u8; 8] = [1, 0, 0, 0, 0, 0, 0, 0];

/// Difference between the definition of a topic in a bag and the present one of its type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SchemaChange {
    /// The first field was `builtin_interfaces/Time stamp` and is `std_msgs/Header header`.
    stamp_became_header: bool,
    /// Lists and texts at the end of the present definition that the former one lacks.
    new_at_end: usize,
}

impl SchemaChange {
    /// Compares a topic with the present definition of its type. No change if the definitions are equal or differ in another respect.
    #[must_use]
    pub fn since(topic: &Topic, now: &str) -> Self {
        if topic.definition == now {
            return Self::default();
        }
        let parse = |text: &str| TypeDefinition::parse(&topic.type_name, text).ok();
        let (Some(former), Some(now)) = (parse(&topic.definition), parse(now)) else { return Self::default() };
        let (Some(before), Some(fields)) = (former.types.first(), now.types.first()) else { return Self::default() };
        let stamp_became_header = is_stamp(before, &former) && is_header(fields, &now);
        let rest = usize::from(stamp_became_header);
        let (before, fields) = (&before[rest..], &fields[rest..]);
        // A new list may have a new type, which stands among the others by its name.
        let Some((kept, since)) = fields.split_at_checked(before.len()) else { return Self::default() };
        // The field behind the frame stands at a multiple of 4 or 8 bytes in both.
        let is_aligned = |field: &Field| match (field.shape, &field.kind) {
            (Multiplicity::Sequence | Multiplicity::BoundedSequence(_), _) | (_, FieldKind::Text(_)) => true,
            (_, FieldKind::Primitive(primitive)) => {
                use Primitive as P;
                matches!(primitive, P::Int32 | P::Uint32 | P::Float32 | P::Int64 | P::Uint64 | P::Float64)
            }
            (_, FieldKind::Nested(_)) => false,
        };
        if stamp_became_header && !kept.first().is_some_and(is_aligned) {
            return Self::default();
        }
        if !are_same((before, &former), (kept, &now)) {
            return Self::default();
        }
        let is_text = |field: &Field| field.shape == Multiplicity::One && matches!(field.kind, FieldKind::Text(_));
        let can_be_empty = |field: &Field| is_list(field.shape) || is_text(field);
        match since.iter().all(can_be_empty) {
            true => Self { stamp_became_header, new_at_end: since.len() },
            false => Self::default(),
        }
    }

    /// Rewrites a recorded message (CDR) as one of the present definition.
    pub fn apply(self, data: &mut Vec<u8>) {
        let behind_time = CDR_HEADER + TIME;
        if self.stamp_became_header && data.len() >= behind_time {
            data.splice(behind_time..behind_time, NO_FRAME);
        }
        if self.new_at_end > 0 {
            data.resize(data.len().next_multiple_of(size_of::<u32>()) + self.new_at_end * size_of::<u32>(), 0);
        }
    }
}

/// The first field is a time named `stamp`.
fn is_stamp(fields: &[Field], definition: &TypeDefinition) -> bool {
    let first = fields.first().filter(|field| field.name == "stamp" && field.shape == Multiplicity::One);
    first.is_some_and(|field| is_time(&field.kind, definition))
}

fn is_time(kind: &FieldKind, definition: &TypeDefinition) -> bool {
    let FieldKind::Nested(index) = kind else { return false };
    let fields = definition.types.get(*index).map_or(&[][..], Vec::as_slice);
    let parts = [("sec", Primitive::Int32), ("nanosec", Primitive::Uint32)];
    let is_part = |(field, (name, primitive)): (&Field, (&str, Primitive))| {
        field.name == name && field.shape == Multiplicity::One && field.kind == FieldKind::Primitive(primitive)
    };
    fields.len() == parts.len() && fields.iter().zip(parts).all(is_part)
}

/// The first field is `std_msgs/Header header`.
fn is_header(fields: &[Field], definition: &TypeDefinition) -> bool {
    let first = fields.first().filter(|field| field.name == "header" && field.shape == Multiplicity::One);
    let Some(FieldKind::Nested(index)) = first.map(|field| &field.kind) else { return false };
    match definition.types.get(*index).map_or(&[][..], Vec::as_slice) {
        [stamp, frame] => {
            stamp.name == "stamp"
                && is_time(&stamp.kind, definition)
                && frame.name == "frame_id"
                && matches!(frame.kind, FieldKind::Text(_))
        }
        _ => false,
    }
}

/// It has any number of elements, also none.
fn is_list(shape: Multiplicity) -> bool {
    matches!(shape, Multiplicity::Sequence | Multiplicity::BoundedSequence(_))
}

/// Fields of two definitions have the same names and layout, and so have the types within them. The elements of a list may have changed: a message
/// in which it is empty can be read, and any other is refused where it is.
fn are_same((ones, one): (&[Field], &TypeDefinition), (others, other): (&[Field], &TypeDefinition)) -> bool {
    let is_same = |(a, b): (&Field, &Field)| {
        let is_same_kind = match (&a.kind, &b.kind) {
            (FieldKind::Nested(_), FieldKind::Nested(_)) if is_list(a.shape) => true,
            (FieldKind::Nested(a), FieldKind::Nested(b)) => match (one.types.get(*a), other.types.get(*b)) {
                (Some(a), Some(b)) => are_same((a, one), (b, other)),
                _ => false,
            },
            (a, b) => a == b,
        };
        is_same_kind && a.name == b.name && a.shape == b.shape
    };
    ones.len() == others.len() && ones.iter().zip(others).all(is_same)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(former: &str, now: &str) -> SchemaChange {
        let topic = Topic {
            name: "/a".into(),
            type_name: "a/msg/A".into(),
            type_hash: String::new(),
            definition: former.into(),
            offered_qos: Vec::new(),
        };
        SchemaChange::since(&topic, now)
    }

    fn fields(former: &str, now: &str) -> usize {
        let change = change(former, now);
        assert!(!change.stamp_became_header);
        change.new_at_end
    }

    #[test]
    fn only_lists_and_texts_at_the_end_are_taken_for_empty() {
        let now = "uint8 a # what\nfloat64[] b\nfloat64[] c\n";
        assert_eq!(fields("uint8 a\nfloat64[] b\n", now), 1);
        assert_eq!(fields("uint8 a\n", now), 2);
        assert_eq!(fields("uint8 a\nfloat64[] b\nfloat64[] c\n", now), 0, "nothing is missing");
        for other in ["uint8 a\nfloat64[] c\n", "uint16 a\n", "uint8 a\nfloat64[] b\nfloat64[] c\nuint8 d\n", "no type"]
        {
            assert_eq!(fields(other, now), 0, "{other}");
        }
        assert_eq!(fields("uint8 a\n", "uint8 a\nuint8 b\n"), 0, "a number is not nothing");
        assert_eq!(fields("uint8 a\n", "uint8 a\nstring b\n"), 1);
        assert_eq!(fields("uint8 a\n", "uint8 a\nstring[2] b\n"), 0, "an array is not empty");
        let part = format!("{}\nMSG: a/P\nuint8 c\n", "=".repeat(80));
        assert_eq!(fields("uint8 a\n", &format!("uint8 a\nP[] b\n{part}")), 1, "a new list of a new type");
        assert_eq!(fields("uint8 a\n", &format!("uint8 a\nP b\n{part}")), 0);
        let between = format!("{}\nMSG: a/N\nuint8 d\n{part}", "=".repeat(80));
        assert_eq!(
            fields(&format!("P a\n{part}"), &format!("P a\nN[] b\n{between}")),
            1,
            "a new type stands before others"
        );
        let other = format!("{}\nMSG: a/P\nuint16 c\n", "=".repeat(80));
        assert_eq!(
            fields(&format!("P[] a\n{other}"), &format!("P[] a\nstring b\n{part}")),
            1,
            "an empty list of a changed type"
        );
        let former = format!("P a\n{other}");
        assert_eq!(fields(&former, &format!("P a\nstring b\n{part}")), 0, "a part has changed");
        let mut data = vec![0, 1, 0, 0, 7];
        SchemaChange { stamp_became_header: false, new_at_end: 2 }.apply(&mut data);
        assert_eq!(data, [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }

    /// The present `PartLobe`, and what an older bag says of it.
    #[test]
    fn a_stamp_becomes_a_header_without_a_frame() {
        use camwright_msgs::Message as _;
        use camwright_msgs::builtin_interfaces::msg::Time;
        use camwright_msgs::camwright_msgs::msg::PartLobe;
        use camwright_msgs::cdr::{message_from_sample, sample_from_message};

        let mut lobe = PartLobe { tick: 7, name: "I1".into(), radius: vec![0.02, 0.03], ..PartLobe::default() };
        lobe.header.stamp = Time { sec: 5, nanosec: 6 };
        let mut data = sample_from_message(&lobe).expect("a message");
        data.drain(12..20);
        let former = PartLobe::SCHEMA.replace("std_msgs/Header header", "builtin_interfaces/Time stamp");
        let since = change(&former, PartLobe::SCHEMA);
        assert_eq!(since, SchemaChange { stamp_became_header: true, new_at_end: 0 });
        since.apply(&mut data);
        assert_eq!(message_from_sample::<PartLobe>(&data), Ok(lobe));
        // A message that is too short stays as it is, for its reader to refuse.
        let mut short = vec![0, 1, 0, 0, 1, 2];
        since.apply(&mut short);
        assert_eq!(short.len(), 6);

        let time = format!("{}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n", "=".repeat(80));
        let header =
            format!("{}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{time}", "=".repeat(80));
        let to_header = |rest: &str| {
            let former = format!("builtin_interfaces/Time stamp\n{rest}{time}");
            change(&former, &format!("std_msgs/Header header\n{rest}{header}")).stamp_became_header
        };
        assert!(to_header("string a\n") && to_header("float64[] a\n") && to_header("uint32 a\n"));
        assert!(!to_header("uint8 a\n"), "it stands at another place behind a text");
    }
}
