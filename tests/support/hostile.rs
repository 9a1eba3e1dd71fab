// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Well-formed messages of any known type, with values that a hostile peer would choose.
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use camwright_msgs::{FieldInfo, by_type_name};

/// Kinds of messages: each field of one takes values of its own.
pub const KINDS: u64 = 4;

const TEXTS: [&str; 4] = ["x_axis", "estop", "eccentric", "job_planner"];

/// The body of a message in little-endian CDR.
pub fn body(type_name: &str, kind: u64) -> Option<Vec<u8>> {
    let mut cdr = Vec::new();
    message(type_name, kind, &mut cdr)?;
    Some(cdr)
}

fn message(type_name: &str, kind: u64, cdr: &mut Vec<u8>) -> Option<()> {
    let info = by_type_name(type_name)?;
    if info.fields.is_empty() {
        cdr.push(0);
    }
    info.fields.iter().try_for_each(|field| value(field, kind, cdr))
}

fn put(cdr: &mut Vec<u8>, octets: &[u8]) {
    while !cdr.len().is_multiple_of(octets.len()) {
        cdr.push(0);
    }
    cdr.extend_from_slice(octets);
}

fn put_length(cdr: &mut Vec<u8>, length: usize) {
    put(cdr, &u32::try_from(length).expect("a short one").to_le_bytes());
}

/// Type ids are those of `type_description_interfaces/msg/FieldType`: in steps of 48 single, array, bounded and unbounded sequence.
fn value(field: &FieldInfo, kind: u64, cdr: &mut Vec<u8>) -> Option<()> {
    let count = match field.type_id / 48 {
        0 => 1,
        1 => usize::try_from(field.capacity).ok()?,
        _ => {
            let count = if kind == 0 { 0 } else { 1 };
            put_length(cdr, count);
            count
        }
    };
    (0..count).try_for_each(|_| single(field, kind, cdr))
}

fn single(field: &FieldInfo, kind: u64, cdr: &mut Vec<u8>) -> Option<()> {
    let number = [1, -1, i64::MAX, 3][usize::try_from(kind).ok()?];
    let real = [1e-4, -0.05, f64::NAN, 1.0][usize::try_from(kind).ok()?];
    let octets = number.to_le_bytes();
    match field.type_id % 48 {
        1 => message(field.nested_type_name, kind, cdr)?,
        2 | 3 | 13 | 16 => cdr.push(octets[0]),
        4 | 5 => put(cdr, &octets[..2]),
        6 | 7 => put(cdr, &octets[..4]),
        8 | 9 => put(cdr, &octets),
        #[allow(clippy::cast_possible_truncation, reason = "a value for a message")]
        10 => put(cdr, &(real as f32).to_le_bytes()),
        11 => put(cdr, &real.to_le_bytes()),
        15 => cdr.push(u8::from(kind.is_multiple_of(2))),
        17 | 21 => {
            let text = TEXTS[usize::try_from(kind).ok()?];
            put_length(cdr, text.len() + 1);
            cdr.extend_from_slice(text.as_bytes());
            cdr.push(0);
        }
        _ => return None,
    }
    Some(())
}
