// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reads packages and adds the messages ROS derives from services and actions.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::Error;
use super::model::{Base, Definition, Field, FieldType, Kind, Multiplicity, Primitive, Source, TypeName};
use super::parse;

/// Largest fixed array: beyond it serde has no implementation.
const LARGEST_ARRAY: usize = 32;

/// Name of the field that an otherwise empty message has, because IDL knows no empty structure.
const PLACEHOLDER: &str = "structure_needs_at_least_one_member";

/// Whose interfaces a package holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Ours: `char` is refused, since readers disagree on its hash.
    Own,
    /// Interfaces of ROS, unchanged.
    Standard,
}

/// Role of a type in a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// A message that gets a Rust structure.
    Message,
    /// The event of a service's introspection: described, without a Rust type of its own.
    Event,
    /// A service: its parts are `_Request`, `_Response`, `_Event`.
    Service,
    /// An action: its parts are `_Goal`, `_Result`, `_Feedback`, `_SendGoal`, `_GetResult`, `_FeedbackMessage`.
    Action,
}

/// One type with everything known about it.
#[derive(Debug, Clone)]
pub(crate) struct Type {
    pub(crate) name: TypeName,
    pub(crate) role: Role,
    pub(crate) definition: Definition,
    pub(crate) source: Source,
}

/// All types.
#[derive(Debug, Default)]
pub(crate) struct Library {
    /// Types by full name.
    pub(crate) types: BTreeMap<TypeName, Type>,
}

/// The packages in a folder, by name.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn packages_in(folder: &Path) -> Result<BTreeMap<String, PathBuf>, Error> {
    Ok(entries(folder)?.into_iter().filter(|(_, path)| path.is_dir()).collect())
}

fn entries(folder: &Path) -> Result<BTreeMap<String, PathBuf>, Error> {
    let fault = |e: std::io::Error| Error { file: folder.to_owned(), line: 0, what: e.to_string() };
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if let Some(name) = path.file_name().and_then(|name| name.to_str()) {
            found.insert(name.to_owned(), path.clone());
        }
    }
    Ok(found)
}

impl Library {
    /// Reads a package's `msg`, `srv` and `action` folders.
    ///
    /// # Errors
    /// The first file that cannot be read, or is not as it should be.
    pub(crate) fn add_package(&mut self, package: &str, folder: &Path, origin: Origin) -> Result<(), Error> {
        for kind in Kind::ALL {
            let folder = folder.join(kind.word());
            if !folder.is_dir() {
                continue;
            }
            for (file_name, path) in entries(&folder)? {
                let error = |line: usize, what: String| Error { file: path.clone(), line, what };
                let Some(name) = file_name.strip_suffix(kind.word()).and_then(|stem| stem.strip_suffix('.')) else {
                    return Err(error(0, format!("only .{} files belong here", kind.word())));
                };
                if !parse::is_message_name(name) {
                    return Err(error(0, format!("{name} is no name for an interface")));
                }
                let text = fs::read_to_string(&path).map_err(|e| error(0, e.to_string()))?;
                self.add_interface(&TypeName::new(package, kind, name), &path, &text, origin)?;
            }
        }
        Ok(())
    }

    /// Reads one interface from its text and adds it with all that follows from it.
    ///
    /// # Errors
    /// The text is not as it should be.
    pub(crate) fn add_interface(
        &mut self,
        name: &TypeName,
        file: &Path,
        text: &str,
        origin: Origin,
    ) -> Result<(), Error> {
        let parts = match name.kind {
            Kind::Msg => vec![(1, text.to_owned())],
            Kind::Srv => split(file, text, 2)?,
            Kind::Action => split(file, text, 3)?,
        };
        let mut definitions = Vec::new();
        for (first_line, part) in &parts {
            let error = |line: usize, what: String| Error { file: file.to_owned(), line, what };
            let definition =
                parse::message(&name.package, part).map_err(|fault| error(first_line + fault.line - 1, fault.what))?;
            for field in &definition.fields {
                if origin == Origin::Own && field.ty.base == Base::Primitive(Primitive::Char) {
                    return Err(error(
                        0,
                        format!("field {}: char is hashed differently by readers; use uint8", field.name),
                    ));
                }
                if matches!(field.ty.shape, Multiplicity::Array(n) if n > LARGEST_ARRAY) {
                    return Err(error(
                        0,
                        format!("field {}: arrays above {LARGEST_ARRAY} elements are not supported", field.name),
                    ));
                }
            }
            definitions.push(definition);
        }
        let mut whole = Definition { text: text.to_owned(), ..Definition::default() };
        if let (Kind::Srv | Kind::Action, Some(first)) = (name.kind, definitions.first()) {
            whole.comment.clone_from(&first.comment);
        }
        let source = |encoding: &'static str| Source {
            file: file.to_owned(),
            encoding,
            text: if encoding == "implicit" { String::new() } else { text.to_owned() },
        };
        let mut parts = definitions.into_iter();
        let mut next = || parts.next().unwrap_or_default();
        match name.kind {
            Kind::Msg => self.add(name.clone(), Role::Message, next(), source("msg")),
            Kind::Srv => {
                self.add(name.derived("_Request"), Role::Message, next(), source("implicit"));
                self.add(name.derived("_Response"), Role::Message, next(), source("implicit"));
                self.add_service(name, whole, source("srv"), source("implicit"));
            }
            Kind::Action => {
                self.add(name.derived("_Goal"), Role::Message, next(), source("implicit"));
                self.add(name.derived("_Result"), Role::Message, next(), source("implicit"));
                self.add(name.derived("_Feedback"), Role::Message, next(), source("implicit"));
                self.add_action(name, whole, source("action"), &source("implicit"));
            }
        }
        Ok(())
    }

    fn add(&mut self, name: TypeName, role: Role, mut definition: Definition, source: Source) {
        if definition.fields.is_empty() && role == Role::Message {
            let byte = FieldType::one(Base::Primitive(Primitive::Uint8));
            definition.fields.push(Field::new(
                PLACEHOLDER,
                byte,
                "Always 0: an empty structure does not exist in IDL.",
            ));
        }
        self.types.insert(name.clone(), Type { name, role, definition, source });
    }

    /// Adds a service whose request and response are there already, with its event.
    fn add_service(&mut self, name: &TypeName, mut whole: Definition, source: Source, implicit: Source) {
        let part = |suffix: &str, shape| FieldType { base: Base::Nested(name.derived(suffix)), shape };
        whole.fields = vec![
            Field::new("request_message", part("_Request", Multiplicity::One), ""),
            Field::new("response_message", part("_Response", Multiplicity::One), ""),
            Field::new("event_message", part("_Event", Multiplicity::One), ""),
        ];
        self.add(name.clone(), Role::Service, whole, source);
        let info = Base::Nested(TypeName::new("service_msgs", Kind::Msg, "ServiceEventInfo"));
        let event = synthetic(vec![
            Field::new("info", FieldType::one(info), ""),
            Field::new("request", part("_Request", Multiplicity::BoundedSequence(1)), ""),
            Field::new("response", part("_Response", Multiplicity::BoundedSequence(1)), ""),
        ]);
        self.add(name.derived("_Event"), Role::Event, event, implicit);
    }

    /// Adds what an action is made of, its goal, result and feedback being there already.
    fn add_action(&mut self, name: &TypeName, mut whole: Definition, source: Source, implicit: &Source) {
        let part = |suffix: &str| FieldType::one(Base::Nested(name.derived(suffix)));
        let id = || {
            let uuid = TypeName::new("unique_identifier_msgs", Kind::Msg, "UUID");
            Field::new("goal_id", FieldType::one(Base::Nested(uuid)), "The goal this is about.")
        };
        let stamp = FieldType::one(Base::Nested(TypeName::new("builtin_interfaces", Kind::Msg, "Time")));
        let flag = FieldType::one(Base::Primitive(Primitive::Bool));
        let status = FieldType::one(Base::Primitive(Primitive::Int8));
        for (suffix, fields) in [
            ("_SendGoal_Request", vec![id(), Field::new("goal", part("_Goal"), "What is wanted.")]),
            (
                "_SendGoal_Response",
                vec![
                    Field::new("accepted", flag, "Whether the goal will be worked on."),
                    Field::new("stamp", stamp, "When it was accepted."),
                ],
            ),
            ("_GetResult_Request", vec![id()]),
            (
                "_GetResult_Response",
                vec![
                    Field::new(
                        "status",
                        status,
                        "How the goal ended, one of `action_msgs::msg::GoalStatus::STATUS_*`.",
                    ),
                    Field::new("result", part("_Result"), "What came of it."),
                ],
            ),
            ("_FeedbackMessage", vec![id(), Field::new("feedback", part("_Feedback"), "How far it is.")]),
        ] {
            self.add(name.derived(suffix), Role::Message, synthetic(fields), implicit.clone());
        }
        for service in ["_SendGoal", "_GetResult"] {
            let service = name.derived(service);
            self.add_service(&service, Definition::default(), implicit.clone(), implicit.clone());
        }
        whole.fields = vec![
            Field::new("goal", part("_Goal"), ""),
            Field::new("result", part("_Result"), ""),
            Field::new("feedback", part("_Feedback"), ""),
            Field::new("send_goal_service", part("_SendGoal"), ""),
            Field::new("get_result_service", part("_GetResult"), ""),
            Field::new("feedback_message", part("_FeedbackMessage"), ""),
        ];
        self.add(name.clone(), Role::Action, whole, source);
    }

    /// Checks that every type a field names is known and that none contains itself.
    ///
    /// # Errors
    /// The first that is not.
    pub(crate) fn check_references(&self) -> Result<(), Error> {
        for ty in self.types.values() {
            let error = |what: String| Error { file: ty.source.file.clone(), line: 0, what };
            for name in nested_in(ty) {
                if !self.types.contains_key(name) {
                    return Err(error(format!("{name} is not known")));
                }
            }
            if self.referenced(&ty.name).contains(&ty.name) {
                return Err(error(format!("{} contains itself", ty.name)));
            }
        }
        Ok(())
    }

    /// Every type that is part of this one, directly or not.
    pub(crate) fn referenced(&self, name: &TypeName) -> BTreeSet<TypeName> {
        let mut found = BTreeSet::new();
        let mut open = vec![name.clone()];
        while let Some(ty) = open.pop().and_then(|name| self.types.get(&name)) {
            for nested in nested_in(ty) {
                if found.insert(nested.clone()) {
                    open.push(nested.clone());
                }
            }
        }
        found
    }
}

/// The types a type names in its fields.
pub(crate) fn nested_in(ty: &Type) -> impl Iterator<Item = &TypeName> {
    ty.definition.fields.iter().filter_map(|field| match &field.ty.base {
        Base::Nested(name) => Some(name),
        _ => None,
    })
}

/// A definition that no file holds, with the text that a file would have.
fn synthetic(fields: Vec<Field>) -> Definition {
    let text = fields.iter().map(|field| format!("{} {}\n", field.ty.word(), field.name)).collect();
    Definition { fields, text, ..Definition::default() }
}

fn split(file: &Path, text: &str, parts: usize) -> Result<Vec<(usize, String)>, Error> {
    parse::split(text, parts).map_err(|fault| Error { file: file.to_owned(), line: fault.line, what: fault.what })
}
