// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Values of constants and defaults, by the rules of `rosidl_adapter`.

use super::model::{Base, FieldType, Multiplicity, Primitive, Value};

/// Reads the default value of a field.
///
/// # Errors
/// What is wrong with the text, as a clause.
pub(crate) fn from_field(ty: &FieldType, text: &str) -> Result<Value, String> {
    if ty.shape == Multiplicity::One {
        return from_base(&ty.base, text);
    }
    if let Base::Nested(name) = &ty.base {
        return Err(format!("a default value is not possible for an array of {name}"));
    }
    let inner = text
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
        .ok_or_else(|| format!("the default {text} of an array must stand in brackets"))?;
    let elements = split_elements(inner)?;
    match ty.shape {
        Multiplicity::Array(n) if elements.len() != n => {
            return Err(format!("the default has {} elements, the array {n}", elements.len()));
        }
        Multiplicity::BoundedSequence(n) if elements.len() > n => {
            return Err(format!("the default has {} elements, the sequence at most {n}", elements.len()));
        }
        _ => {}
    }
    Ok(Value::List(elements.iter().map(|element| from_base(&ty.base, element)).collect::<Result<_, _>>()?))
}

/// Reads a single value.
///
/// # Errors
/// What is wrong with the text, as a clause.
pub(crate) fn from_base(base: &Base, text: &str) -> Result<Value, String> {
    match base {
        Base::Nested(name) => Err(format!("a default value is not possible for a {name}")),
        Base::Text(bound) => {
            let value = unquote(text)?;
            match bound {
                Some(bound) if value.len() > *bound => {
                    Err(format!("the text is {} bytes long, at most {bound} are allowed", value.len()))
                }
                _ => Ok(Value::Text(value)),
            }
        }
        Base::Primitive(Primitive::Bool) => match text.to_ascii_lowercase().as_str() {
            "true" | "1" => Ok(Value::Bool(true)),
            "false" | "0" => Ok(Value::Bool(false)),
            _ => Err(format!("{text} is neither true nor false")),
        },
        Base::Primitive(Primitive::Float32 | Primitive::Float64) => {
            text.parse().map(Value::Float).map_err(|_| format!("{text} is not a number"))
        }
        Base::Primitive(primitive) => {
            let value = integer(text).ok_or_else(|| format!("{text} is not an integer"))?;
            match primitive.integer_range() {
                Some((low, high)) if !(low..=high).contains(&value) => {
                    Err(format!("{value} does not fit {}, which is {low} to {high}", primitive.word()))
                }
                _ => Ok(Value::Integer(value)),
            }
        }
    }
}

/// A decimal integer, or one with the prefix 0x, 0o or 0b.
fn integer(text: &str) -> Option<i128> {
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let lower = digits.to_ascii_lowercase();
    let (radix, digits) = [("0x", 16), ("0o", 8), ("0b", 2)]
        .iter()
        .find_map(|(prefix, radix)| lower.strip_prefix(prefix).map(|digits| (*radix, digits)))?;
    // `from_str_radix` would take a second sign.
    let value =
        digits.starts_with(|c: char| c.is_ascii_hexdigit()).then(|| i128::from_str_radix(digits, radix).ok())??;
    Some(if negative { -value } else { value })
}

/// Takes the quotes off a text; without quotes it is taken as it stands.
fn unquote(text: &str) -> Result<String, String> {
    for quote in ['"', '\''] {
        let Some(rest) = text.strip_prefix(quote) else { continue };
        let escaped = format!("\\{quote}");
        let Some(inner) = rest.strip_suffix(quote) else {
            return Err(format!("the text {text} has no closing quote (a # starts a comment even within quotes)"));
        };
        if inner.replace(&escaped, "").contains(quote) {
            return Err(format!("the text {text} has an unescaped quote inside"));
        }
        return Ok(inner.replace(&escaped, &quote.to_string()));
    }
    Ok(text.to_owned())
}

/// Splits at commas outside quotes.
fn split_elements(text: &str) -> Result<Vec<String>, String> {
    let mut elements = Vec::new();
    let mut element = String::new();
    let mut quote = None;
    let mut escaped = false;
    for c in text.chars() {
        match quote {
            Some(q) if c == q && !escaped => quote = None,
            None if (c == '"' || c == '\'') && element.trim().is_empty() => quote = Some(c),
            None if c == ',' => {
                elements.push(element.trim().to_owned());
                element.clear();
                continue;
            }
            _ => {}
        }
        escaped = c == '\\' && !escaped;
        element.push(c);
    }
    if quote.is_some() {
        return Err(format!("a quote is not closed in [{text}]"));
    }
    if !(element.trim().is_empty() && elements.is_empty()) {
        elements.push(element.trim().to_owned());
    }
    match elements.iter().position(String::is_empty) {
        Some(index) => Err(format!("element {index} of [{text}] is empty")),
        None => Ok(elements),
    }
}
