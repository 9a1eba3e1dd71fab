// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Every type that is known, for those who learn its name at run time.

use crate::type_description_interfaces::msg::{
    Field, FieldType, IndividualTypeDescription, TypeDescription, TypeSource,
};

/// Kind of a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InterfaceKind {
    /// Something that travels: a topic's message, or a part of a service or an action.
    Message,
    /// A service, made of a request, a response and an event.
    Service,
    /// An action, made of a goal, a result and feedback, and what carries them.
    Action,
}

/// A field as its type's description has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldInfo {
    /// Name of the field.
    pub name: &'static str,
    /// One of the constants of [`FieldType`].
    pub type_id: u8,
    /// Number of elements: of an array exactly, of a bounded sequence at most, else 0.
    pub capacity: u64,
    /// Largest length of a bounded text, else 0.
    pub string_capacity: u64,
    /// Full name of the nested type, or empty.
    pub nested_type_name: &'static str,
    /// Default value as rosidl prints it, or empty.
    pub default_value: &'static str,
}

/// All that is known of a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InterfaceInfo {
    /// Full name, for example `sensor_msgs/msg/JointState`.
    pub type_name: &'static str,
    /// Name on the wire, for example `sensor_msgs::msg::dds_::JointState_`.
    pub dds_type_name: &'static str,
    /// `RIHS01_` and 64 hexadecimal digits.
    pub type_hash: &'static str,
    pub kind: InterfaceKind,
    /// Definition with all dependencies, as a bag carries it (`ros2msg`); empty for services and actions.
    pub schema: &'static str,
    /// `msg`, `srv` or `action`; `implicit` for a type derived from another, which has no file.
    pub source_encoding: &'static str,
    /// The file it comes from, whole; empty for a derived type.
    pub source: &'static str,
    /// Its fields, in order.
    pub fields: &'static [FieldInfo],
    /// Full names of all types it is made of, directly or not, in order.
    pub referenced: &'static [&'static str],
}

/// Every type that is known, in the order of names.
pub const ALL: &[&InterfaceInfo] = crate::generated_registry::ALL;

/// Finds a type by its full name, for example `sensor_msgs/msg/JointState`.
pub fn by_type_name(type_name: &str) -> Option<&'static InterfaceInfo> {
    ALL.binary_search_by(|info| info.type_name.cmp(type_name)).ok().map(|index| ALL[index])
}

impl InterfaceInfo {
    /// The type and all types it is made of, itself first.
    fn family(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(self.referenced.iter().filter_map(|name| by_type_name(name)))
    }

    /// The description that a node's `get_type_description` service answers with.
    pub fn type_description(&self) -> TypeDescription {
        TypeDescription {
            type_description: self.individual(),
            referenced_type_descriptions: self.family().skip(1).map(Self::individual).collect(),
        }
    }

    /// The files behind the description, for the same service.
    pub fn type_sources(&self) -> Vec<TypeSource> {
        let source = |info: &Self| TypeSource {
            type_name: info.type_name.to_owned(),
            encoding: info.source_encoding.to_owned(),
            raw_file_contents: info.source.to_owned(),
        };
        self.family().map(source).collect()
    }

    fn individual(&self) -> IndividualTypeDescription {
        let field = |field: &FieldInfo| Field {
            name: field.name.to_owned(),
            type_: FieldType {
                type_id: field.type_id,
                capacity: field.capacity,
                string_capacity: field.string_capacity,
                nested_type_name: field.nested_type_name.to_owned(),
            },
            default_value: field.default_value.to_owned(),
        };
        IndividualTypeDescription {
            type_name: self.type_name.to_owned(),
            fields: self.fields.iter().map(field).collect(),
        }
    }
}
