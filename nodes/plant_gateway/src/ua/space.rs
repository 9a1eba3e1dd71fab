// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Address space of the server: types of the companion models, the folder of machines, and the nodes of this machine.

use super::Nameplate;
use super::model::{self, ModelId, UaNamespace, UaStateMachine, UaUnit};
use super::nodes::{NODES, NameplateField, NodeKind, NodeReading, NodeSource, UaData, UaNode, UaReference};
use opcua::nodes::{
    DataTypeBuilder, EventNotifier, ImportedItem, ImportedReference, NodeSetImport, NodeSetNamespaceMapper, NodeType,
    ObjectBuilder, ObjectTypeBuilder, VariableBuilder, VariableTypeBuilder,
};
use opcua::types::{
    DataTypeId, DataValue, DateTime, EUInformation, EnumValueType, ExtensionObject, LocalizedText, NodeId, ObjectId,
    QualifiedName, Range, ReferenceTypeId, StatusCode, Variant,
};

/// Identifier of the machine in the namespace of the cell.
const MACHINE: &str = "Machine";
/// Namespaces by [`UaNamespace::index`].
const NAMESPACES: usize = UaNamespace::ADDED.len() + 1;

/// Identifiers of nodes in a server.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeIds([u16; NAMESPACES]);

impl NodeIds {
    /// Identifiers with the indices of the namespaces in a server; `None` if one is missing.
    pub(super) fn find(index: impl Fn(UaNamespace) -> Option<u16>) -> Option<Self> {
        let mut indices = [0; NAMESPACES];
        for namespace in UaNamespace::ADDED {
            indices[usize::from(namespace.index())] = index(namespace)?;
        }
        Some(Self(indices))
    }

    pub(super) fn index(&self, namespace: UaNamespace) -> u16 {
        self.0[usize::from(namespace.index())]
    }

    pub(super) fn model(&self, (namespace, id): ModelId) -> NodeId {
        NodeId::new(self.index(namespace), id)
    }

    /// Node of the machine by its path; the machine itself for an empty path.
    pub(super) fn path(&self, path: &str) -> NodeId {
        NodeId::new(self.index(UaNamespace::Cell), if path.is_empty() { MACHINE } else { path })
    }

    fn name(&self, namespace: UaNamespace, name: &str) -> QualifiedName {
        QualifiedName::new(self.index(namespace), name)
    }

    /// Values of the variables of a node: of one, or of the three of a state machine.
    pub(super) fn values(&self, node: &UaNode, reading: &NodeReading, time: DateTime) -> Vec<(NodeId, DataValue)> {
        let good = |value: Variant| DataValue::new_at(value, time);
        let bad = |status| DataValue::new_at_status(Variant::Empty, time, status);
        match (node.kind, reading) {
            (_, NodeReading::Constant) | (NodeKind::Object(_) | NodeKind::Link(_), _) => Vec::new(),
            (NodeKind::States(machine, _), reading) => {
                let state = match reading {
                    NodeReading::State(state) => machine.states.get(*state).map(|known| (*state, known)),
                    _ => None,
                };
                let values = match state {
                    Some((number, state)) => [
                        good(LocalizedText::new("en", state.name).into()),
                        good(self.model((machine.type_id.0, state.id)).into()),
                        good(u32::try_from(number).unwrap_or_default().into()),
                    ],
                    None => [(); 3].map(|()| bad(StatusCode::BadNoCommunication)),
                };
                STATE_VARIABLES
                    .map(|name| self.path(&format!("{}/{name}", node.path)))
                    .into_iter()
                    .zip(values)
                    .collect()
            }
            (NodeKind::Variable { .. }, reading) => {
                let value = match reading {
                    NodeReading::Value(value) => good(value.clone()),
                    NodeReading::Unsupported => bad(StatusCode::BadNotSupported),
                    _ => bad(StatusCode::BadNoCommunication),
                };
                vec![(self.path(node.path), value)]
            }
        }
    }
}

/// Variables of a state machine.
const STATE_VARIABLES: [&str; 3] = ["CurrentState", "CurrentState/Id", "CurrentState/Number"];

/// All nodes that this server adds to the standard ones.
#[derive(Debug)]
pub(super) struct CellNodeSet {
    /// URI of the namespace of the cell.
    pub(super) uri: String,
    /// Browse name of the machine.
    pub(super) machine: String,
    pub(super) nameplate: Nameplate,
    pub(super) time: DateTime,
}

impl NodeSetImport for CellNodeSet {
    fn register_namespaces(&self, namespaces: &mut NodeSetNamespaceMapper) {
        for namespace in UaNamespace::ADDED {
            namespaces.add_namespace(namespace.uri().unwrap_or(&self.uri), namespace.index());
        }
    }

    fn get_own_namespaces(&self) -> Vec<String> {
        UaNamespace::ADDED.map(|namespace| namespace.uri().unwrap_or(&self.uri).to_owned()).into()
    }

    fn load<'a>(&'a self, namespaces: &'a NodeSetNamespaceMapper) -> Box<dyn Iterator<Item = ImportedItem> + 'a> {
        let ids = NodeIds::find(|namespace| namespaces.get_index(namespace.index()).ok());
        Box::new(ids.map(|ids| Builder { ids, set: self, items: Vec::new() }.build()).into_iter().flatten())
    }
}

/// A variable before it is in the address space.
struct NewVariable {
    id: NodeId,
    name: QualifiedName,
    parent: NodeId,
    reference: UaReference,
    type_id: ModelId,
    data_type: NodeId,
    is_list: bool,
    value: DataValue,
}

/// Collects the nodes.
struct Builder<'a> {
    ids: NodeIds,
    set: &'a CellNodeSet,
    items: Vec<ImportedItem>,
}

fn reference(type_id: ReferenceTypeId, target_id: NodeId, is_forward: bool) -> ImportedReference {
    ImportedReference { target_id, type_id: type_id.into(), is_forward }
}

impl UaReference {
    const fn type_id(self) -> ReferenceTypeId {
        match self {
            Self::Component => ReferenceTypeId::HasComponent,
            Self::Property => ReferenceTypeId::HasProperty,
            Self::AddIn => ReferenceTypeId::HasAddIn,
            Self::OrderedComponent => ReferenceTypeId::HasOrderedComponent,
        }
    }
}

impl Builder<'_> {
    fn build(mut self) -> Vec<ImportedItem> {
        self.types();
        self.enumerations();
        model::STATE_MACHINES.iter().for_each(|machine| self.states(machine));
        self.machine();
        for node in NODES {
            self.node(node);
        }
        self.items
    }

    fn add(&mut self, node: impl Into<NodeType>, references: Vec<ImportedReference>) {
        self.items.push(ImportedItem { node: node.into(), references });
    }

    fn type_definition(&self, id: ModelId) -> ImportedReference {
        reference(ReferenceTypeId::HasTypeDefinition, self.ids.model(id), true)
    }

    fn types(&mut self) {
        for kind in model::TYPES {
            let (id, name) = (self.ids.model(kind.id), self.ids.name(kind.id.0, kind.name));
            let references = vec![reference(ReferenceTypeId::HasSubtype, self.ids.model(kind.parent), false)];
            if kind.is_variable {
                let builder = VariableTypeBuilder::new(&id, name, kind.name).data_type(DataTypeId::Number);
                self.add(builder.is_abstract(kind.is_abstract).build(), references);
            } else {
                let builder = ObjectTypeBuilder::new(&id, name, kind.name).is_abstract(kind.is_abstract);
                self.add(builder.build(), references);
            }
        }
        // Clients ask for it in filters of events.
        let (id, name) = (self.ids.model(model::ALERT_ERROR_CODE), self.ids.name(model::ALERT.0, "ErrorCode"));
        self.property((id, name), self.ids.model(model::ALERT), DataTypeId::String, Variant::Empty);
    }

    fn enumerations(&mut self) {
        for kind in model::ENUMERATIONS {
            let (id, name) = (self.ids.model(kind.id), self.ids.name(kind.id.0, kind.name));
            let parent = NodeId::from(DataTypeId::Enumeration);
            let references = vec![reference(ReferenceTypeId::HasSubtype, parent, false)];
            self.add(DataTypeBuilder::new(&id, name, kind.name).build(), references);
            let values = (0..).zip(kind.values).map(|(value, name)| EnumValueType {
                value,
                display_name: LocalizedText::new("", name),
                description: LocalizedText::null(),
            });
            let values: Vec<ExtensionObject> = values.map(ExtensionObject::from_message).collect();
            let names = (self.ids.model((kind.id.0, kind.values_id)), QualifiedName::new(0, "EnumValues"));
            self.property(names, id, DataTypeId::EnumValueType, values.into());
        }
    }

    /// States of a type.
    fn states(&mut self, machine: &UaStateMachine) {
        let namespace = machine.type_id.0;
        for (number, state) in (0_u32..).zip(machine.states) {
            let (id, name) = (self.ids.model((namespace, state.id)), self.ids.name(namespace, state.name));
            let is_initial = machine.has_initial && number == 0;
            let kind = self.type_definition(if is_initial { model::INITIAL_STATE } else { model::STATE });
            let parent = reference(ReferenceTypeId::HasComponent, self.ids.model(machine.type_id), false);
            self.add(ObjectBuilder::new(&id, name, state.name).build(), vec![kind, parent]);
            let names = (self.ids.model((namespace, state.number_id)), QualifiedName::new(0, "StateNumber"));
            self.property(names, id, DataTypeId::UInt32, number.into());
        }
    }

    /// The folder of all machines and this machine.
    fn machine(&mut self) {
        let machines = self.ids.model(model::MACHINES);
        let folder = ObjectBuilder::new(&machines, self.ids.name(UaNamespace::Machinery, "Machines"), "Machines");
        let objects = reference(ReferenceTypeId::Organizes, ObjectId::ObjectsFolder.into(), false);
        let references = vec![self.type_definition(model::FOLDER), objects];
        self.add(folder.build(), references);
        let name = self.set.machine.as_str();
        let machine = ObjectBuilder::new(&self.ids.path(""), self.ids.name(UaNamespace::Cell, name), name);
        let parent = reference(ReferenceTypeId::Organizes, machines, false);
        let references = vec![self.type_definition(model::MACHINE_TOOL), parent];
        self.add(machine.build(), references);
    }

    fn node(&mut self, node: &UaNode) {
        let (id, parent) = (self.ids.path(node.path), self.ids.path(node.parent()));
        let name = self.ids.name(node.namespace, node.name());
        let upwards = reference(node.reference.type_id(), parent.clone(), false);
        match node.kind {
            NodeKind::Object(kind) => {
                let mut object = ObjectBuilder::new(&id, name, node.name());
                let mut references = vec![self.type_definition(kind), upwards];
                if kind == model::MESSAGES {
                    object = object.event_notifier(EventNotifier::SUBSCRIBE_TO_EVENTS);
                    references.push(reference(ReferenceTypeId::GeneratesEvent, self.ids.model(model::ALERT), true));
                }
                self.add(object.build(), references);
            }
            NodeKind::Link(path) => {
                // The target comes before its links, and gets another parent.
                let target = self.ids.path(path);
                let known = self.items.iter_mut().find(|item| *item.node.as_node().node_id() == target);
                if let Some(known) = known {
                    known.references.push(upwards);
                }
            }
            NodeKind::States(machine, _) => {
                let object = ObjectBuilder::new(&id, name, node.name());
                let references = vec![self.type_definition(machine.type_id), upwards];
                self.add(object.build(), references);
                self.state_variables(node);
            }
            NodeKind::Variable { data, source, type_id, .. } => {
                let kind = type_id.unwrap_or(match (node.reference, data) {
                    (UaReference::Property, _) => model::PROPERTY,
                    (_, UaData::Analog(_, Some(_))) => model::ANALOG_UNIT_RANGE,
                    (_, UaData::Analog(_, None)) => model::ANALOG_UNIT,
                    _ => model::BASE_DATA_VARIABLE,
                });
                self.variable(NewVariable {
                    id,
                    name,
                    parent,
                    reference: node.reference,
                    type_id: kind,
                    data_type: self.data_type(data),
                    is_list: matches!(data, UaData::UInt16List | UaData::TextList),
                    value: self.first_value(data, source),
                });
                if let UaData::Analog(unit, range) = data {
                    self.units(node.path, unit, range);
                }
            }
        }
    }

    /// `CurrentState` with `Id` and `Number`.
    fn state_variables(&mut self, node: &UaNode) {
        let machine = self.ids.path(node.path);
        let state = self.ids.path(&format!("{}/{}", node.path, STATE_VARIABLES[0]));
        let kinds = [
            (machine, UaReference::Component, model::STATE_VARIABLE, DataTypeId::LocalizedText),
            (state.clone(), UaReference::Property, model::PROPERTY, DataTypeId::NodeId),
            (state, UaReference::Property, model::PROPERTY, DataTypeId::UInt32),
        ];
        let values = self.ids.values(node, &NodeReading::Unavailable, self.set.time);
        for (((id, value), (parent, reference, type_id, data)), path) in
            values.into_iter().zip(kinds).zip(STATE_VARIABLES)
        {
            let name = QualifiedName::new(0, path.rsplit_once('/').map_or(path, |(_, name)| name));
            let data_type = data.into();
            self.variable(NewVariable { id, name, parent, reference, type_id, data_type, is_list: false, value });
        }
    }

    fn units(&mut self, path: &str, unit: &UaUnit, range: Option<(f64, f64)>) {
        let of_node = |name: &str| (self.ids.path(&format!("{path}/{name}")), QualifiedName::new(0, name));
        let (units, limits, parent) = (of_node("EngineeringUnits"), of_node("EURange"), self.ids.path(path));
        self.property(units, parent.clone(), DataTypeId::EUInformation, unit_value(unit));
        if let Some((low, high)) = range {
            self.property(limits, parent, DataTypeId::Range, Range { low, high }.into());
        }
    }

    /// Value before the first message: that of a constant, or none.
    fn first_value(&self, data: UaData, source: NodeSource) -> DataValue {
        let Nameplate { manufacturer, serial_number, product_instance_uri } = &self.set.nameplate;
        let text = |text: &Option<String>| text.as_deref().unwrap_or("unknown").to_owned();
        let value: Variant = match (source, data) {
            (NodeSource::Fixed(_), UaData::Unit(unit)) => unit_value(unit),
            (NodeSource::Fixed(value), _) => value(),
            (NodeSource::Nameplate(NameplateField::Manufacturer), _) => {
                LocalizedText::new("", &text(manufacturer)).into()
            }
            (NodeSource::Nameplate(NameplateField::SerialNumber), _) => text(serial_number).into(),
            (NodeSource::Nameplate(NameplateField::ProductInstanceUri), _) => {
                product_instance_uri.clone().unwrap_or_else(|| self.set.uri.clone()).into()
            }
            _ => return DataValue::new_at_status(Variant::Empty, self.set.time, StatusCode::BadNoCommunication),
        };
        DataValue::new_at(value, self.set.time)
    }

    fn data_type(&self, data: UaData) -> NodeId {
        match data {
            UaData::Boolean => DataTypeId::Boolean.into(),
            UaData::UInt16 | UaData::UInt16List => DataTypeId::UInt16.into(),
            UaData::UInt32 => DataTypeId::UInt32.into(),
            UaData::UInt64 => DataTypeId::UInt64.into(),
            UaData::Duration => DataTypeId::Duration.into(),
            UaData::Text | UaData::TextList => DataTypeId::String.into(),
            UaData::Localized => DataTypeId::LocalizedText.into(),
            UaData::Number | UaData::Analog(..) => DataTypeId::Double.into(),
            UaData::Enumeration(kind) => self.ids.model(kind.id),
            UaData::Unit(_) => DataTypeId::EUInformation.into(),
        }
    }

    /// A constant property.
    fn property(&mut self, (id, name): (NodeId, QualifiedName), parent: NodeId, data: DataTypeId, value: Variant) {
        self.variable(NewVariable {
            id,
            name,
            parent,
            reference: UaReference::Property,
            type_id: model::PROPERTY,
            data_type: data.into(),
            is_list: matches!(value, Variant::Array(_)),
            value: DataValue::new_at(value, self.set.time),
        });
    }

    fn variable(&mut self, new: NewVariable) {
        let name = new.name.name.to_string();
        let builder = VariableBuilder::new(&new.id, new.name, name.as_str()).data_type(new.data_type);
        let builder = if new.is_list { builder.value_rank(1).array_dimensions(&[0]) } else { builder.value_rank(-1) };
        let mut variable = builder.build();
        variable.set_data_value(new.value);
        let upwards = reference(new.reference.type_id(), new.parent, false);
        let references = vec![self.type_definition(new.type_id), upwards];
        self.add(variable, references);
    }
}

fn unit_value(unit: &UaUnit) -> Variant {
    let information = EUInformation {
        namespace_uri: UaUnit::NAMESPACE.into(),
        unit_id: unit.id(),
        display_name: LocalizedText::new("", unit.symbol),
        description: LocalizedText::new("", unit.name),
    };
    information.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use opcua::nodes::NamespaceMap;
    use opcua::types::NodeClass;
    use std::collections::BTreeSet;

    fn set(nameplate: Nameplate) -> CellNodeSet {
        CellNodeSet { uri: "urn:test:cell".into(), machine: "cell_2".into(), nameplate, time: DateTime::null() }
    }

    /// Nodes of the set in a server whose namespaces have other indices, and their identifiers.
    fn loaded(set: &CellNodeSet) -> (Vec<ImportedItem>, NodeIds) {
        let mut map = NamespaceMap::new();
        map.add_namespace("urn:test:other");
        let mut mapper = NodeSetNamespaceMapper::new(&mut map);
        set.register_namespaces(&mut mapper);
        let ids = NodeIds::find(|namespace| mapper.get_index(namespace.index()).ok()).expect("registered");
        (set.load(&mapper).collect(), ids)
    }

    fn value_of(items: &[ImportedItem], id: &NodeId) -> DataValue {
        let found = items.iter().find_map(|item| match &item.node {
            NodeType::Variable(variable) if item.node.as_node().node_id() == id => Some(variable),
            _ => None,
        });
        let variable = found.unwrap_or_else(|| panic!("{id} is no variable"));
        variable.value(
            opcua::types::TimestampsToReturn::Both,
            &opcua::types::NumericRange::None,
            &opcua::types::DataEncoding::Binary,
            0.0,
        )
    }

    #[test]
    fn every_reference_ends_at_a_node_of_the_set_or_of_the_standard() {
        let (items, ids) = loaded(&set(Nameplate::default()));
        assert_eq!(ids.index(UaNamespace::Di), 2, "after the standard and another one");
        let known: BTreeSet<String> = items.iter().map(|item| item.node.as_node().node_id().to_string()).collect();
        assert_eq!(known.len(), items.len(), "an identifier is there twice");
        for item in &items {
            let id = item.node.as_node().node_id();
            let is_upward = |reference: &&ImportedReference| !reference.is_forward;
            assert!(item.references.iter().any(|reference| is_upward(&reference)), "{id} has no parent");
            for reference in &item.references {
                let target = &reference.target_id;
                assert!(target.namespace == 0 || known.contains(&target.to_string()), "{id} refers to {target}");
            }
            let is_instance = matches!(item.node.as_node().node_class(), NodeClass::Object | NodeClass::Variable);
            let has_type = item
                .references
                .iter()
                .filter(|reference| reference.type_id == ReferenceTypeId::HasTypeDefinition && reference.is_forward);
            assert_eq!(has_type.count(), usize::from(is_instance), "{id}");
        }
    }

    #[test]
    fn no_variable_can_be_written() {
        let (items, _) = loaded(&set(Nameplate::default()));
        let mut variables = 0;
        for item in &items {
            assert!(item.node.as_node().write_mask().is_none(), "an attribute of a node can be written");
            if let NodeType::Variable(variable) = &item.node {
                assert!(!variable.is_writable() && !variable.is_user_writable());
                variables += 1;
            }
            assert_ne!(item.node.as_node().node_class(), NodeClass::Method);
        }
        assert!(variables > 80, "{variables} variables");
    }

    #[test]
    fn values_before_the_first_message_are_bad_and_constants_are_good() {
        let (items, ids) = loaded(&set(Nameplate { serial_number: Some("7".into()), ..Nameplate::default() }));
        let value = |path: &str| value_of(&items, &ids.path(path));
        for path in ["Axes/X/Position", "Production/ActiveProgram/State/CurrentState", "Cell/State"] {
            let first = value(path);
            assert_eq!((first.status, first.value), (Some(StatusCode::BadNoCommunication), Some(Variant::Empty)));
        }
        assert_eq!(value("Identification/SerialNumber").value, Some("7".into()));
        assert_eq!(value("Identification/Manufacturer").value, Some(LocalizedText::new("", "unknown").into()));
        assert_eq!(value("Identification/ProductInstanceUri").value, Some("urn:test:cell".into()));
        let range = value("Monitoring/Channel/FeedOverride/EURange").value;
        assert_eq!(range, Some(Range { low: 0.0, high: 100.0 }.into()));
    }

    #[test]
    fn a_state_has_text_identifier_and_number() {
        let (_, ids) = loaded(&set(Nameplate::default()));
        let path = "Production/ActiveProgram/State";
        let node = NODES.iter().find(|node| node.path == path).expect("a node");
        let values = ids.values(node, &NodeReading::State(1), DateTime::null());
        let values: Vec<_> = values.into_iter().map(|(id, value)| (id, value.value)).collect();
        let running = NodeId::new(ids.index(UaNamespace::MachineTool), 5041);
        let expected = [
            (ids.path(&format!("{path}/CurrentState")), Some(LocalizedText::new("en", "Running").into())),
            (ids.path(&format!("{path}/CurrentState/Id")), Some(running.into())),
            (ids.path(&format!("{path}/CurrentState/Number")), Some(1_u32.into())),
        ];
        assert_eq!(values, expected);
        let lost = ids.values(node, &NodeReading::Unavailable, DateTime::null());
        assert!(lost.iter().all(|(_, value)| value.status == Some(StatusCode::BadNoCommunication)), "{lost:?}");
    }
}
