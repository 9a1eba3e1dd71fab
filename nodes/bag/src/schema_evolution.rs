//! Messages that were recorded when their type had fewer fields: what came to it since stands at its end, and is empty.

use super::Topic;
use super::definition::{Field, FieldKind, TypeDefinition};
use camwright_msgs::syntax::Multiplicity;

/// Number of lists and texts that the present definition of a type has in addition to that of a topic. 0 if the definitions are equal or
/// differ in any other respect.
pub fn fields_since(topic: &Topic, now: &str) -> usize {
    if topic.definition == now {
        return 0;
    }
    let parse = |text: &str| TypeDefinition::parse(&topic.type_name, text).ok();
    let (Some(former), Some(now)) = (parse(&topic.definition), parse(now)) else { return 0 };
    let ([former, former_parts @ ..], [now, parts @ ..]) = (&former.types[..], &now.types[..]) else { return 0 };
    // The types that only new lists use come after those that were used before.
    let Some(since) = now.strip_prefix(&former[..]).filter(|_| parts.starts_with(former_parts)) else { return 0 };
    let can_be_empty = |field: &Field| match field.shape {
        Multiplicity::Sequence | Multiplicity::BoundedSequence(_) => true,
        Multiplicity::One => matches!(field.kind, FieldKind::Text(_)),
        Multiplicity::Array(_) => false,
    };
    if since.iter().all(can_be_empty) { since.len() } else { 0 }
}

/// Gives a message in CDR so many empty lists and texts at its end: of each the number of its elements.
pub fn add_empty_fields(data: &mut Vec<u8>, fields: usize) {
    if fields > 0 {
        data.resize(data.len().next_multiple_of(size_of::<u32>()) + fields * size_of::<u32>(), 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(former: &str, now: &str) -> usize {
        let topic = Topic {
            name: "/a".into(),
            type_name: "a/msg/A".into(),
            type_hash: String::new(),
            definition: former.into(),
            offered_qos: Vec::new(),
        };
        fields_since(&topic, now)
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
        let other = format!("{}\nMSG: a/P\nuint16 c\n", "=".repeat(80));
        let former = format!("P a\n{other}");
        assert_eq!(fields(&former, &format!("P a\nstring b\n{part}")), 0, "a part has changed");
        let mut data = vec![0, 1, 0, 0, 7];
        add_empty_fields(&mut data, 2);
        assert_eq!(data, [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }
}
