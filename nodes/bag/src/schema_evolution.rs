//! Messages that were recorded when their type had fewer fields: what came to it since stands at its end, and is empty.

use super::Topic;
use super::definition::TypeDefinition;
use camwright_msgs::syntax::Multiplicity;

/// Number of lists that the present definition of a type has in addition to that of a topic. 0 if the definitions are equal or differ in any
/// other respect.
pub fn lists_since(topic: &Topic, now: &str) -> usize {
    if topic.definition == now {
        return 0;
    }
    let parse = |text: &str| TypeDefinition::parse(&topic.type_name, text).ok();
    let (Some(former), Some(now)) = (parse(&topic.definition), parse(now)) else { return 0 };
    let ([former, former_parts @ ..], [now, parts @ ..]) = (&former.types[..], &now.types[..]) else { return 0 };
    match now.strip_prefix(&former[..]) {
        Some(since)
            if former_parts == parts
                && since
                    .iter()
                    .all(|field| matches!(field.shape, Multiplicity::Sequence | Multiplicity::BoundedSequence(_))) =>
        {
            since.len()
        }
        _ => 0,
    }
}

/// Gives a message in CDR so many empty lists at its end: of each the number of its elements.
pub fn add_empty_lists(data: &mut Vec<u8>, lists: usize) {
    if lists > 0 {
        data.resize(data.len().next_multiple_of(size_of::<u32>()) + lists * size_of::<u32>(), 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lists(former: &str, now: &str) -> usize {
        let topic = Topic {
            name: "/a".into(),
            type_name: "a/msg/A".into(),
            type_hash: String::new(),
            definition: former.into(),
            offered_qos: Vec::new(),
        };
        lists_since(&topic, now)
    }

    #[test]
    fn only_lists_at_the_end_are_taken_for_empty() {
        let now = "uint8 a # what\nfloat64[] b\nfloat64[] c\n";
        assert_eq!(lists("uint8 a\nfloat64[] b\n", now), 1);
        assert_eq!(lists("uint8 a\n", now), 2);
        assert_eq!(lists("uint8 a\nfloat64[] b\nfloat64[] c\n", now), 0, "nothing is missing");
        for other in ["uint8 a\nfloat64[] c\n", "uint16 a\n", "uint8 a\nfloat64[] b\nfloat64[] c\nuint8 d\n", "no type"]
        {
            assert_eq!(lists(other, now), 0, "{other}");
        }
        assert_eq!(lists("uint8 a\n", "uint8 a\nuint8 b\n"), 0, "a number is not nothing");
        let mut data = vec![0, 1, 0, 0, 7];
        add_empty_lists(&mut data, 2);
        assert_eq!(data, [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }
}
