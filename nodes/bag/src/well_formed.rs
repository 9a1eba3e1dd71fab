// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Check of a message against its definition, to its last byte.

use super::definition::{Field, FieldKind, TypeDefinition};
use super::values::CdrCursor;
use camwright_msgs::syntax::{Multiplicity, Primitive};

/// Walks through a message by its definition.
///
/// # Errors
/// One sentence that names the field: the message ends within it, or it has a value that its type has not.
pub(super) fn well_formed(definition: &TypeDefinition, data: &[u8]) -> Result<(), String> {
    let mut cursor = CdrCursor::new(data)?;
    fields(&mut cursor, definition, 0)?;
    // What travels is filled up to a multiple of four bytes.
    let left = cursor.left();
    if left > 3 || (left > 0 && !data.len().is_multiple_of(4)) {
        return Err(format!("{left} bytes are left behind its last field"));
    }
    Ok(())
}

fn fields(cursor: &mut CdrCursor<'_>, definition: &TypeDefinition, index: usize) -> Result<(), String> {
    let all = definition.types.get(index).map_or(&[][..], Vec::as_slice);
    if all.is_empty() {
        // A type without fields travels as one byte.
        return cursor.read(1).map(drop);
    }
    all.iter().try_for_each(|one| {
        field(cursor, definition, one).map_err(|reason| match reason.split_once(": ") {
            // The fields within come first.
            Some((inner, reason)) if matches!(one.kind, FieldKind::Nested(_)) => {
                format!("{}.{inner}: {reason}", one.name)
            }
            _ => format!("{}: {reason}", one.name),
        })
    })
}

fn field(cursor: &mut CdrCursor<'_>, definition: &TypeDefinition, field: &Field) -> Result<(), String> {
    let count = cursor.count(field.shape)?;
    if let Multiplicity::BoundedSequence(max) = field.shape
        && count > max
    {
        return Err(format!("{count} elements, {max} are allowed"));
    }
    match &field.kind {
        FieldKind::Nested(index) => (0..count).try_for_each(|_| fields(cursor, definition, *index)),
        FieldKind::Text(max) => (0..count).try_for_each(|_| text(cursor, *max)),
        FieldKind::Primitive(primitive) => primitives(cursor, *primitive, count),
    }
}

fn primitives(cursor: &mut CdrCursor<'_>, primitive: Primitive, count: usize) -> Result<(), String> {
    use Primitive as P;
    match primitive {
        P::Bool => match cursor.read(count)?.iter().find(|byte| **byte > 1) {
            Some(byte) => Err(format!("{byte} is neither true nor false")),
            None => Ok(()),
        },
        P::Byte | P::Char | P::Int8 | P::Uint8 => cursor.read(count).map(drop),
        P::Int16 | P::Uint16 => numbers::<2>(cursor, count),
        P::Int32 | P::Uint32 | P::Float32 => numbers::<4>(cursor, count),
        P::Int64 | P::Uint64 | P::Float64 => numbers::<8>(cursor, count),
    }
}

/// Skips numbers, for which any bit pattern is valid.
fn numbers<const N: usize>(cursor: &mut CdrCursor<'_>, count: usize) -> Result<(), String> {
    if count == 0 {
        return Ok(());
    }
    cursor.number::<N>()?;
    let bytes = (count - 1).checked_mul(N).ok_or("more elements than there can be")?;
    cursor.read(bytes).map(drop)
}

fn text(cursor: &mut CdrCursor<'_>, max: Option<usize>) -> Result<(), String> {
    let length = usize::try_from(cursor.length()?).map_err(|error| error.to_string())?;
    let bytes = cursor.read(length)?;
    let Some((0, letters)) = bytes.split_last() else { return Err("a text without the zero at its end".into()) };
    if letters.contains(&0) {
        return Err("a text with a zero within".into());
    }
    if std::str::from_utf8(letters).is_err() {
        return Err("a text that is not UTF-8".into());
    }
    match max {
        Some(max) if letters.len() > max => Err(format!("a text of {} bytes, {max} are allowed", letters.len())),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(text: &str, body: &[u8]) -> Result<(), String> {
        let definition = TypeDefinition::parse("a/msg/A", text).expect("it is right");
        well_formed(&definition, &[&[0, 1, 0, 0], body].concat())
    }

    fn refusal(text: &str, body: &[u8]) -> String {
        judged(text, body).expect_err("it is malformed")
    }

    #[test]
    fn every_field_is_looked_at_and_nothing_may_be_left() {
        let inner = format!("int8 n\nB b\n{}\nMSG: a/B\nbool[] flags\n", "=".repeat(80));
        assert_eq!(judged(&inner, &[1, 0, 0, 0, 2, 0, 0, 0, 0, 1]), Ok(()));
        assert_eq!(refusal(&inner, &[1, 0, 0, 0, 2, 0, 0, 0, 0, 7]), "b.flags: 7 is neither true nor false");
        assert_eq!(
            refusal(&inner, &[1, 0, 0, 0, 3, 0, 0, 0, 0, 1]),
            "b.flags: 3 elements are announced, 2 bytes are left"
        );
        assert_eq!(judged("int8 n\n", &[1, 0, 0, 0]), Ok(()), "filled up to four bytes");
        assert_eq!(refusal("int8 n\n", &[1, 0, 0]), "2 bytes are left behind its last field");
        assert_eq!(refusal("int8 n\n", &[1, 0, 0, 0, 0]), "4 bytes are left behind its last field");
        assert_eq!(refusal("float64[2] d\n", &[0; 15]), "d: the message ends after 15 bytes");
        assert_eq!(judged("float64[] d\n", &[0; 4]), Ok(()), "no elements need no alignment");
    }

    #[test]
    fn texts_end_in_a_zero_and_keep_their_bounds() {
        assert_eq!(judged("string<=2 s\n", &[3, 0, 0, 0, b'h', b'i', 0]), Ok(()));
        assert_eq!(refusal("string<=1 s\n", &[3, 0, 0, 0, b'h', b'i', 0]), "s: a text of 2 bytes, 1 are allowed");
        assert_eq!(refusal("string s\n", &[2, 0, 0, 0, b'h', b'i']), "s: a text without the zero at its end");
        assert_eq!(refusal("string s\n", &[0; 4]), "s: a text without the zero at its end");
        assert_eq!(refusal("string s\n", &[3, 0, 0, 0, 0, b'i', 0]), "s: a text with a zero within");
        assert_eq!(refusal("string s\n", &[2, 0, 0, 0, 0xff, 0]), "s: a text that is not UTF-8");
        assert_eq!(refusal("int8[<=1] n\n", &[2, 0, 0, 0, 1, 2]), "n: 2 elements, 1 are allowed");
    }
}
