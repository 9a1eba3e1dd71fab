// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Content of an interface file.

pub(crate) use super::syntax::{Multiplicity, Primitive};
use std::fmt;
use std::path::PathBuf;

/// Which folder of a package an interface belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// `msg`
    Msg,
    /// `srv`
    Srv,
    /// `action`
    Action,
}

impl Kind {
    /// All kinds, in the order modules are written.
    pub(crate) const ALL: [Self; 3] = [Self::Msg, Self::Srv, Self::Action];

    /// Folder name, file extension and middle part of a type name, which are the same word.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Msg => "msg",
            Self::Srv => "srv",
            Self::Action => "action",
        }
    }
}

/// Full name of a type, for example `std_srvs/srv/Trigger_Request`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TypeName {
    pub(crate) package: String,
    pub(crate) kind: Kind,
    pub(crate) name: String,
}

impl TypeName {
    /// Name of a type in a package's folder.
    pub(crate) fn new(package: &str, kind: Kind, name: &str) -> Self {
        Self { package: package.to_owned(), kind, name: name.to_owned() }
    }

    /// The same with a suffix, for example `Trigger` and `_Request`.
    pub(crate) fn derived(&self, suffix: &str) -> Self {
        Self::new(&self.package, self.kind, &format!("{}{suffix}", self.name))
    }

    /// Name on the wire, for example `std_srvs::srv::dds_::Trigger_Request_`.
    pub(crate) fn dds(&self) -> String {
        format!("{}::{}::dds_::{}_", self.package, self.kind.word(), self.name)
    }

    /// Name of the Rust type: `Trigger_Request` becomes `TriggerRequest`.
    pub(crate) fn rust(&self) -> String {
        self.name.replace('_', "")
    }

    /// Path of the Rust type from the crate's root.
    pub(crate) fn rust_path(&self) -> String {
        format!("crate::{}::{}::{}", self.package, self.kind.word(), self.rust())
    }
}

impl fmt::Display for TypeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.package, self.kind.word(), self.name)
    }
}

impl Primitive {
    /// The Rust type.
    pub(crate) fn rust(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Byte | Self::Char | Self::Uint8 => "u8",
            Self::Float32 => "f32",
            Self::Float64 => "f64",
            Self::Int8 => "i8",
            Self::Int16 => "i16",
            Self::Uint16 => "u16",
            Self::Int32 => "i32",
            Self::Uint32 => "u32",
            Self::Int64 => "i64",
            Self::Uint64 => "u64",
        }
    }

    /// Smallest and largest value of an integer type, `None` for the others.
    pub(crate) fn integer_range(self) -> Option<(i128, i128)> {
        Some(match self {
            Self::Byte | Self::Char | Self::Uint8 => (0, u8::MAX.into()),
            Self::Int8 => (i8::MIN.into(), i8::MAX.into()),
            Self::Int16 => (i16::MIN.into(), i16::MAX.into()),
            Self::Uint16 => (0, u16::MAX.into()),
            Self::Int32 => (i32::MIN.into(), i32::MAX.into()),
            Self::Uint32 => (0, u32::MAX.into()),
            Self::Int64 => (i64::MIN.into(), i64::MAX.into()),
            Self::Uint64 => (0, u64::MAX.into()),
            Self::Bool | Self::Float32 | Self::Float64 => return None,
        })
    }
}

/// Type of one element of a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Base {
    Primitive(Primitive),
    /// Text, with its largest length in bytes if it has one.
    Text(Option<usize>),
    Nested(TypeName),
}

/// Type of a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FieldType {
    pub(crate) base: Base,
    pub(crate) shape: Multiplicity,
}

impl FieldType {
    /// A single element.
    pub(crate) fn one(base: Base) -> Self {
        Self { base, shape: Multiplicity::One }
    }

    /// Word of an interface file, with the package in front of every nested type.
    pub(crate) fn word(&self) -> String {
        let base = match &self.base {
            Base::Primitive(primitive) => primitive.word().to_owned(),
            Base::Text(None) => "string".to_owned(),
            Base::Text(Some(bound)) => format!("string<={bound}"),
            Base::Nested(name) => format!("{}/{}", name.package, name.name),
        };
        match self.shape {
            Multiplicity::One => base,
            Multiplicity::Array(n) => format!("{base}[{n}]"),
            Multiplicity::BoundedSequence(n) => format!("{base}[<={n}]"),
            Multiplicity::Sequence => format!("{base}[]"),
        }
    }
}

/// Value of a constant or a default.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Bool(bool),
    Integer(i128),
    Float(f64),
    Text(String),
    List(Vec<Value>),
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) ty: FieldType,
    pub(crate) default: Option<Value>,
    pub(crate) comment: Vec<String>,
}

impl Field {
    /// A field without default.
    pub(crate) fn new(name: &str, ty: FieldType, comment: &str) -> Self {
        let comment = if comment.is_empty() { Vec::new() } else { vec![comment.to_owned()] };
        Self { name: name.to_owned(), ty, default: None, comment }
    }
}

/// A constant of a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Constant {
    pub(crate) name: String,
    pub(crate) base: Base,
    pub(crate) value: Value,
    pub(crate) comment: Vec<String>,
}

/// One message: a `.msg` file, or one part of a `.srv` or `.action` file.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Definition {
    pub(crate) comment: Vec<String>,
    pub(crate) fields: Vec<Field>,
    pub(crate) constants: Vec<Constant>,
    /// The text it was read from, verbatim.
    pub(crate) text: String,
}

/// Source of a type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Source {
    pub(crate) file: PathBuf,
    /// `msg`, `srv` or `action`; `implicit` for a type that ROS derives from another.
    pub(crate) encoding: &'static str,
    /// The file whole; empty for an implicit type.
    pub(crate) text: String,
}
