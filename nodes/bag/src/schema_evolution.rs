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
    let (Some(before), Some(fields)) = (former.types.first(), now.types.first()) else { return 0 };
    // A new list may have a new type, which stands among the others by its name.
    let Some((kept, since)) = fields.split_at_checked(before.len()) else { return 0 };
    if !are_same((before, &former), (kept, &now)) {
        return 0;
    }
    let is_text = |field: &Field| field.shape == Multiplicity::One && matches!(field.kind, FieldKind::Text(_));
    let can_be_empty = |field: &Field| is_list(field.shape) || is_text(field);
    if since.iter().all(can_be_empty) { since.len() } else { 0 }
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
        add_empty_fields(&mut data, 2);
        assert_eq!(data, [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }
}
