// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The values of a message, found in its CDR by the definition that stands in the bag.

use super::definition::{Field, FieldKind, TypeDefinition};
use camwright_msgs::syntax::{Multiplicity, Primitive};

/// Maximum number of elements of an array that is passed on as a whole; each takes the memory of a value.
const MAX_LISTED: usize = 4 << 20;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum FieldValue {
    Bool(bool),
    /// With the width of its type (bits).
    Signed(i64, u8),
    Unsigned(u64, u8),
    Float32(f32),
    Float64(f64),
    Text(String),
    /// Elements of a list that is too long for a column each, never empty.
    List(Vec<FieldValue>),
}

/// Reads a message: `visit` gets each value with its path, as `joint.position[2]`. Arrays longer than `longest` are passed on as a
/// list, or as one text where their elements have parts.
///
/// # Errors
/// One sentence about where the message ends before its definition does.
pub(super) fn read(
    definition: &TypeDefinition,
    data: &[u8],
    longest: usize,
    visit: &mut dyn FnMut(&str, FieldValue),
) -> Result<(), String> {
    let mut cursor = CdrCursor::new(data)?;
    let mut path = String::new();
    cursor.fields(definition, 0, &mut path, longest, visit)
}

/// A place in the CDR of a message.
pub(super) struct CdrCursor<'a> {
    pub(super) body: &'a [u8],
    pub(super) at: usize,
    is_little: bool,
}

impl<'a> CdrCursor<'a> {
    /// At the beginning of a message, behind the four bytes that say which CDR it is.
    pub(super) fn new(data: &'a [u8]) -> Result<Self, String> {
        let (head, body) = data.split_at_checked(4).ok_or("it has no four bytes of CDR")?;
        let is_little = match head[..2] {
            [0, 1] => true,
            [0, 0] => false,
            _ => return Err(format!("its representation 0x{:02x}{:02x} is not plain CDR", head[0], head[1])),
        };
        Ok(Self { body, at: 0, is_little })
    }

    fn fields(
        &mut self,
        definition: &TypeDefinition,
        index: usize,
        path: &mut String,
        longest: usize,
        visit: &mut dyn FnMut(&str, FieldValue),
    ) -> Result<(), String> {
        let fields = definition.types.get(index).map_or(&[][..], Vec::as_slice);
        if fields.is_empty() {
            // A type without fields travels as one byte.
            return self.read(1).map(drop);
        }
        for field in fields {
            let length = path.len();
            if !path.is_empty() {
                path.push('.');
            }
            path.push_str(&field.name);
            self.field(definition, field, path, longest, visit).map_err(|reason| format!("{path}: {reason}"))?;
            path.truncate(length);
        }
        Ok(())
    }

    fn field(
        &mut self,
        definition: &TypeDefinition,
        field: &Field,
        path: &mut String,
        longest: usize,
        visit: &mut dyn FnMut(&str, FieldValue),
    ) -> Result<(), String> {
        let count = match field.shape {
            Multiplicity::One => return self.one(definition, &field.kind, path, longest, visit),
            _ => self.count(field.shape)?,
        };
        if count <= longest {
            for element in 0..count {
                let length = path.len();
                path.push_str(&format!("[{element}]"));
                self.one(definition, &field.kind, path, longest, visit)?;
                path.truncate(length);
            }
            return Ok(());
        }
        if count > MAX_LISTED {
            return Err(format!("{count} elements, {MAX_LISTED} are the most in a table"));
        }
        // Too long for columns: its values in order, and one text where they have names.
        let mut values = Vec::new();
        for _ in 0..count {
            self.one(definition, &field.kind, &mut String::new(), usize::MAX, &mut |_, value| values.push(value))?;
        }
        let list = FieldValue::List(values);
        visit(path, if matches!(field.kind, FieldKind::Nested(_)) { FieldValue::Text(plain(&list)) } else { list });
        Ok(())
    }

    fn primitive(&mut self, primitive: Primitive) -> Result<FieldValue, String> {
        use Primitive as P;
        Ok(match primitive {
            P::Bool => FieldValue::Bool(self.number::<1>()?[0] != 0),
            P::Int8 => FieldValue::Signed(i8::from_le_bytes(self.number()?).into(), 8),
            P::Byte | P::Char | P::Uint8 => FieldValue::Unsigned(u8::from_le_bytes(self.number()?).into(), 8),
            P::Int16 => FieldValue::Signed(i16::from_le_bytes(self.number()?).into(), 16),
            P::Uint16 => FieldValue::Unsigned(u16::from_le_bytes(self.number()?).into(), 16),
            P::Int32 => FieldValue::Signed(i32::from_le_bytes(self.number()?).into(), 32),
            P::Uint32 => FieldValue::Unsigned(self.length()?.into(), 32),
            P::Int64 => FieldValue::Signed(i64::from_le_bytes(self.number()?), 64),
            P::Uint64 => FieldValue::Unsigned(u64::from_le_bytes(self.number()?), 64),
            P::Float32 => FieldValue::Float32(f32::from_le_bytes(self.number()?)),
            P::Float64 => FieldValue::Float64(f64::from_le_bytes(self.number()?)),
        })
    }

    fn one(
        &mut self,
        definition: &TypeDefinition,
        kind: &FieldKind,
        path: &mut String,
        longest: usize,
        visit: &mut dyn FnMut(&str, FieldValue),
    ) -> Result<(), String> {
        let value = match kind {
            FieldKind::Nested(index) => return self.fields(definition, *index, path, longest, visit),
            FieldKind::Primitive(primitive) => self.primitive(*primitive)?,
            FieldKind::Text(_) => {
                let length = usize::try_from(self.length()?).map_err(|error| error.to_string())?;
                let bytes = self.read(length)?;
                // The length counts the zero at the end.
                let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
                FieldValue::Text(String::from_utf8_lossy(bytes).into_owned())
            }
        };
        visit(path, value);
        Ok(())
    }

    /// Number of following elements: at most the number of remaining bytes, since each has at least one.
    pub(super) fn count(&mut self, shape: Multiplicity) -> Result<usize, String> {
        let count = match shape {
            Multiplicity::One => 1,
            Multiplicity::Array(count) => count,
            Multiplicity::Sequence | Multiplicity::BoundedSequence(_) => {
                usize::try_from(self.length()?).map_err(|error| error.to_string())?
            }
        };
        let left = self.left();
        if count > left { Err(format!("{count} elements are announced, {left} bytes are left")) } else { Ok(count) }
    }

    /// Bytes that have not been read.
    pub(super) fn left(&self) -> usize {
        self.body.len().saturating_sub(self.at)
    }

    pub(super) fn length(&mut self) -> Result<u32, String> {
        self.number().map(u32::from_le_bytes)
    }

    /// The bytes of a number, the least first.
    pub(super) fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.at = self.at.next_multiple_of(N);
        let mut bytes: [u8; N] = self.read(N)?.try_into().map_err(|_| "too few bytes".to_owned())?;
        if !self.is_little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub(super) fn read(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.body.len());
        let end = end.ok_or_else(|| format!("the message ends after {} bytes", self.body.len()))?;
        let bytes = &self.body[self.at..end];
        self.at = end;
        Ok(bytes)
    }
}

/// A value as it reads back to the same bits.
pub(super) fn plain(value: &FieldValue) -> String {
    match value {
        FieldValue::Bool(value) => value.to_string(),
        FieldValue::Signed(value, _) => value.to_string(),
        FieldValue::Unsigned(value, _) => value.to_string(),
        // With an exponent where it is shorter.
        FieldValue::Float32(value) => format!("{value:?}"),
        FieldValue::Float64(value) => format!("{value:?}"),
        FieldValue::Text(value) => value.clone(),
        FieldValue::List(values) => values.iter().map(plain).collect::<Vec<_>>().join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str, data: &[u8], longest: usize) -> Result<Vec<(String, String)>, String> {
        let definition = TypeDefinition::parse("a/msg/A", text).expect("it is right");
        let mut all = Vec::new();
        read(&definition, data, longest, &mut |path, value| all.push((path.to_owned(), plain(&value))))?;
        Ok(all)
    }

    fn pairs(expected: &[(&str, &str)]) -> Vec<(String, String)> {
        expected.iter().map(|(path, value)| ((*path).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn values_stand_where_cdr_aligns_them_in_both_orders_of_bytes() {
        let text =
            "bool b\nfloat64 f\nint16[2] i\nstring s\nB[] n\n".to_owned() + &"=".repeat(80) + "\nMSG: a/B\nuint8 u\n";
        let little = [
            &[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..],
            &(-0.1_f64).to_le_bytes(),
            &(-2_i16).to_le_bytes(),
            &3_i16.to_le_bytes(),
            &[3, 0, 0, 0, b'h', b'i', 0, 0, 2, 0, 0, 0, 7, 8],
        ]
        .concat();
        let expected = [
            ("b", "true"),
            ("f", "-0.1"),
            ("i[0]", "-2"),
            ("i[1]", "3"),
            ("s", "hi"),
            ("n[0].u", "7"),
            ("n[1].u", "8"),
        ];
        assert_eq!(values(&text, &little, 9), Ok(pairs(&expected)));
        let big = [
            &[0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..],
            &(-0.1_f64).to_be_bytes(),
            &(-2_i16).to_be_bytes(),
            &3_i16.to_be_bytes(),
            &[0, 0, 0, 3, b'h', b'i', 0, 0, 0, 0, 0, 2, 7, 8],
        ]
        .concat();
        assert_eq!(values(&text, &big, 9), Ok(pairs(&expected)));
        let expected = [("b", "true"), ("f", "-0.1"), ("i", "-2 3"), ("s", "hi"), ("n", "7 8")];
        assert_eq!(values(&text, &little, 1), Ok(pairs(&expected)), "what is too long for columns is one text");
        for cut in 0..little.len() {
            assert!(values(&text, &little[..cut], 9).is_err(), "{cut} bytes are too few");
        }
    }

    #[test]
    fn a_length_that_no_message_can_have_is_refused_before_anything_is_made_of_it() {
        let read = values("float64[] f\n", &[0, 1, 0, 0, 255, 255, 255, 255], 9);
        assert_eq!(read, Err("f: 4294967295 elements are announced, 0 bytes are left".into()));
        assert_eq!(values("int8 a\n", &[0, 3, 0, 0, 1], 9), Err("its representation 0x0003 is not plain CDR".into()));
    }
}
