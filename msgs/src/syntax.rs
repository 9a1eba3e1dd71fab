// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Types of fields as interface files write them, for example `string<=32[]` or `geometry_msgs/Point[<=4]`.
//!
//! The generator of this crate and readers of recorded definitions share this grammar.

/// A type that no package defines, other than text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    Bool,
    Byte,
    /// An unsigned byte, despite its name.
    Char,
    Float32,
    Float64,
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
}

impl Primitive {
    const ALL: [Self; 13] = [
        Self::Bool,
        Self::Byte,
        Self::Char,
        Self::Float32,
        Self::Float64,
        Self::Int8,
        Self::Uint8,
        Self::Int16,
        Self::Uint16,
        Self::Int32,
        Self::Uint32,
        Self::Int64,
        Self::Uint64,
    ];

    /// The primitive type with this word.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|primitive| primitive.word() == word)
    }

    /// Word in an interface file.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Byte => "byte",
            Self::Char => "char",
            Self::Float32 => "float32",
            Self::Float64 => "float64",
            Self::Int8 => "int8",
            Self::Uint8 => "uint8",
            Self::Int16 => "int16",
            Self::Uint16 => "uint16",
            Self::Int32 => "int32",
            Self::Uint32 => "uint32",
            Self::Int64 => "int64",
            Self::Uint64 => "uint64",
        }
    }
}

/// Number of elements of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Multiplicity {
    One,
    Array(usize),
    BoundedSequence(usize),
    Sequence,
}

/// Type of one element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element<'a> {
    Primitive(Primitive),
    /// Text, with its maximum length in bytes if it is bounded.
    Text(Option<usize>),
    /// Name of a type, with or without its package.
    Named(&'a str),
}

/// Type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TypeText<'a> {
    pub element: Element<'a>,
    pub shape: Multiplicity,
}

/// Error in a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TypeError<'a> {
    /// `[` without `]`.
    Unclosed,
    /// `]` without `[`.
    Unopened,
    /// The text in brackets is no number of elements.
    Size(&'a str),
    /// The text after `<=` is no length of a text.
    Length(&'a str),
}

impl<'a> TypeText<'a> {
    /// Reads a type. Bounds may be 0; arrays have at least one element.
    ///
    /// # Errors
    /// Brackets that do not match, a size or a length that is no number.
    pub fn parse(text: &'a str) -> Result<Self, TypeError<'a>> {
        let (element, shape) = match (text.strip_suffix(']'), text.contains('[')) {
            (None, false) => (text, Multiplicity::One),
            (None, true) => return Err(TypeError::Unclosed),
            (Some(open), _) => {
                let (element, size) = open.rsplit_once('[').ok_or(TypeError::Unopened)?;
                (element, shape(size).ok_or(TypeError::Size(size))?)
            }
        };
        let element = match (Primitive::named(element), element.strip_prefix("string")) {
            (Some(primitive), _) => Element::Primitive(primitive),
            (None, Some("")) => Element::Text(None),
            (None, Some(bounded)) if bounded.starts_with("<=") => {
                let length = &bounded[2..];
                Element::Text(Some(length.parse().map_err(|_| TypeError::Length(length))?))
            }
            _ => Element::Named(element),
        };
        Ok(Self { element, shape })
    }
}

fn shape(size: &str) -> Option<Multiplicity> {
    match size.strip_prefix("<=") {
        Some(bound) => bound.parse().ok().map(Multiplicity::BoundedSequence),
        None if size.is_empty() => Some(Multiplicity::Sequence),
        None => size.parse().ok().filter(|size| *size > 0).map(Multiplicity::Array),
    }
}

/// Code of a line, and its comment without the `#`.
#[must_use]
pub fn split_comment(line: &str) -> (&str, Option<&str>) {
    match line.split_once('#') {
        Some((code, comment)) => (code, Some(comment)),
        None => (line, None),
    }
}
