// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Device model of a machine for an MTConnect agent: `Devices.xml`.

use crate::cell_messages::Equipment;
use crate::items::{Component, ITEMS, Item};
use crate::shdr::{MTCONNECT_VERSION, id_prefix};
use camwright::machine::description::MachineDescription;
use camwright_threads::system_time::utc;
use std::fmt::Write;

/// A component with those within it.
struct Node(Component, &'static [Node]);

const AXES: &[Node] = &[
    Node(Component::CAxis, &[Node(Component::Chuck, &[])]),
    Node(Component::XAxis, &[]),
    Node(Component::ZAxis, &[]),
    Node(Component::Wheel, &[]),
];

/// Device model of a machine in the cell of a namespace. The name of the device is that of the namespace, in `/` that of the machine.
#[must_use]
pub fn document(machine: &MachineDescription, namespace: &str, time_ns: i64) -> String {
    let prefix = id_prefix(namespace);
    let name = if prefix.is_empty() { machine.name.as_str() } else { prefix.trim_end_matches('_') };
    let mut text = Document { prefix: &prefix, equipment: Equipment::of_machine(machine), text: String::new() };
    // A string takes everything.
    let _infallible = text.write(machine, name, &utc(u64::try_from(time_ns).unwrap_or_default()));
    text.text
}

struct Document<'a> {
    prefix: &'a str,
    equipment: Equipment,
    text: String,
}

impl Document<'_> {
    fn write(&mut self, machine: &MachineDescription, name: &str, time: &str) -> std::fmt::Result {
        let (prefix, version, name) = (self.prefix, MTCONNECT_VERSION, escaped(name));
        writeln!(self.text, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
        writeln!(self.text, "<MTConnectDevices xmlns=\"urn:mtconnect.org:MTConnectDevices:{version}\">")?;
        writeln!(
            self.text,
            "  <Header version=\"{version}\" creationTime=\"{time}\" deviceModelChangeTime=\"{time}\" sender=\"camwright\" \
             instanceId=\"1\" bufferSize=\"131072\" assetBufferSize=\"1024\" assetCount=\"0\"/>"
        )?;
        writeln!(self.text, "  <Devices>")?;
        writeln!(
            self.text,
            "    <Device id=\"{prefix}device\" name=\"{name}\" uuid=\"camwright_{name}\" mtconnectVersion=\"{version}\">"
        )?;
        let (model, hash) = (escaped(&machine.name), machine.hash.get(..12).unwrap_or_default());
        writeln!(self.text, "      <Description model=\"{model}\">Machine file {hash}</Description>")?;
        self.data_items(Component::Device, 6)?;
        writeln!(self.text, "      <Components>")?;
        writeln!(self.text, "        <Axes id=\"{prefix}axes\" name=\"axes\">")?;
        writeln!(self.text, "          <Components>")?;
        self.components(AXES, 12)?;
        writeln!(self.text, "          </Components>")?;
        writeln!(self.text, "        </Axes>")?;
        self.components(&[Node(Component::Controller, &[Node(Component::Path, &[])]), Node(Component::Door, &[])], 8)?;
        writeln!(self.text, "      </Components>")?;
        writeln!(self.text, "    </Device>")?;
        writeln!(self.text, "  </Devices>")?;
        writeln!(self.text, "</MTConnectDevices>")
    }

    fn items(&self, component: Component) -> impl Iterator<Item = &'static Item> + use<> {
        let equipment = self.equipment;
        ITEMS.iter().filter(move |item| item.component == component && (item.applies)(equipment))
    }

    /// The components that the machine has: those with data items.
    fn components(&mut self, nodes: &[Node], indent: usize) -> std::fmt::Result {
        for Node(component, within) in nodes {
            if self.items(*component).next().is_none() {
                continue;
            }
            let (element, prefix) = (component.element(), self.prefix);
            writeln!(
                self.text,
                "{:indent$}<{element} id=\"{prefix}{}\" name=\"{}\">",
                "",
                component.id(),
                component.name()
            )?;
            self.data_items(*component, indent + 2)?;
            if within.iter().any(|Node(part, _)| self.items(*part).next().is_some()) {
                writeln!(self.text, "{:1$}<Components>", "", indent + 2)?;
                self.components(within, indent + 4)?;
                writeln!(self.text, "{:1$}</Components>", "", indent + 2)?;
            }
            writeln!(self.text, "{:indent$}</{element}>", "")?;
        }
        Ok(())
    }

    fn data_items(&mut self, component: Component, indent: usize) -> std::fmt::Result {
        writeln!(self.text, "{:indent$}<DataItems>", "")?;
        for item in self.items(component) {
            let (category, kind, prefix) = (item.category.name(), item.kind, self.prefix);
            let attribute = |name: &str, value: Option<&str>| {
                value.map_or_else(String::new, |value| format!(" {name}=\"{value}\""))
            };
            let (sub_type, units) = (attribute("subType", item.sub_type), attribute("units", item.units));
            let id = item.id;
            writeln!(
                self.text,
                "{:indent$}  <DataItem id=\"{prefix}{id}\" category=\"{category}\" type=\"{kind}\"{sub_type}{units}/>",
                ""
            )?;
        }
        writeln!(self.text, "{:indent$}</DataItems>", "")
    }
}

/// Text in an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_messages::CellMessages;
    use crate::items::{Category, read_all};
    use crate::shdr::changes;
    use camwright_files::machine_file;
    use std::collections::{BTreeMap, BTreeSet};
    use std::path::Path;

    /// Names of the model: type, category, sub-types, units. Read in the model of MTConnect (version 2.6, as the Python package
    /// pymtconnect 1.0.1 has it), and in `libraries/MTConnect.NET-Common/Devices/DataItems` of `TrakHound/MTConnect.NET`, which also states
    /// the version of each type: none is newer than 1.6. Spelling of units in XML: `UnitEnum` of `MtconnectTranspiler.Sinks.CSharp`.
    const MODEL: &[(&str, &str, &[&str], &str)] = &[
        ("AVAILABILITY", "EVENT", &[], ""),
        ("EMERGENCY_STOP", "EVENT", &[], ""),
        ("EQUIPMENT_TIMER", "SAMPLE", &["POWERED", "OPERATING", "WORKING"], "SECOND"),
        ("CONTROLLER_MODE", "EVENT", &[], ""),
        ("EXECUTION", "EVENT", &[], ""),
        ("PROGRAM", "EVENT", &[], ""),
        ("PATH_FEEDRATE_OVERRIDE", "EVENT", &["PROGRAMMED"], ""),
        ("PART_COUNT", "EVENT", &["ALL", "GOOD", "BAD", "TARGET", "REMAINING"], ""),
        ("TOOL_NUMBER", "EVENT", &[], ""),
        ("PART_DETECT", "EVENT", &[], ""),
        ("ANGLE", "SAMPLE", &["ACTUAL"], "DEGREE"),
        ("ROTARY_VELOCITY", "SAMPLE", &["ACTUAL"], "REVOLUTION/MINUTE"),
        ("TORQUE", "SAMPLE", &[], "NEWTON_METER"),
        ("ROTARY_MODE", "EVENT", &[], ""),
        ("POSITION", "SAMPLE", &["ACTUAL"], "MILLIMETER"),
        ("AXIS_FEEDRATE", "SAMPLE", &["ACTUAL"], "MILLIMETER/SECOND"),
        ("LINEAR_FORCE", "SAMPLE", &[], "NEWTON"),
        ("WATTAGE", "SAMPLE", &["ACTUAL"], "WATT"),
        ("DIAMETER", "SAMPLE", &[], "MILLIMETER"),
        ("CHUCK_STATE", "EVENT", &[], ""),
        ("DOOR_STATE", "EVENT", &[], ""),
        ("SYSTEM", "CONDITION", &[], ""),
    ];

    /// Components of the model and elements of its XML form: `ComponentTypes` of the same package, `test_config.xml` of mtconnect/cppagent.
    const COMPONENTS: [&str; 8] = ["Device", "Axes", "Rotary", "Linear", "Controller", "Path", "Chuck", "Door"];

    /// Elements of a document with their attributes and parents; fails where it is not well-formed.
    fn elements(text: &str) -> Vec<(String, String, BTreeMap<String, String>)> {
        let body = text.strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n").expect("a declaration");
        let (mut open, mut all) = (Vec::<String>::new(), Vec::new());
        for part in body.split('<').skip(1) {
            let (tag, rest) = part.split_once('>').expect("the end of a tag");
            assert!(!rest.contains('>') && (open.len() > 1 || rest.trim().is_empty()), "{part}");
            if let Some(name) = tag.strip_prefix('/') {
                assert_eq!(open.pop().as_deref(), Some(name), "{part}");
                continue;
            }
            let (tag, is_empty) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
            let (name, mut left) = tag.split_once(' ').unwrap_or((tag, ""));
            let mut attributes = BTreeMap::new();
            while !left.is_empty() {
                let (attribute, value) = left.split_once("=\"").expect("a quoted value");
                let (value, next) = value.split_once('"').expect("the end of a value");
                assert!(attributes.insert(attribute.trim().to_owned(), value.to_owned()).is_none(), "{part}");
                left = next;
            }
            all.push((open.last().cloned().unwrap_or_default(), name.to_owned(), attributes));
            if !is_empty {
                open.push(name.to_owned());
            }
        }
        assert!(open.is_empty(), "{open:?} are not closed");
        all
    }

    fn machine(name: &str, keys: &[&str]) -> MachineDescription {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params/machines").join(name);
        let text = std::fs::read_to_string(&path).expect("a machine file");
        let keys: Vec<String> = keys.iter().map(ToString::to_string).collect();
        machine_file::parse(&path, &text, &keys).expect("a machine").description
    }

    /// All machines of the repository, and one with door and chuck.
    fn machines() -> Vec<MachineDescription> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../params/machines");
        let names = std::fs::read_dir(folder).expect("machines").map(|entry| entry.expect("a file").file_name());
        let mut all: Vec<_> = names.map(|name| machine(&name.to_string_lossy(), &[])).collect();
        all.push(machine("cam_grinder.yaml", &[LOADING]));
        assert!(all.len() > 5, "{} machines", all.len());
        all
    }

    const LOADING: &str =
        "loading={door: {opens_ms: 500, closes_ms: 500}, chuck: {opens_ms: 200, closes_ms: 200}, safe_x_mm: 120}";

    /// The device model and the lines of the adapter name the same items.
    #[test]
    fn ids_of_the_device_model_are_the_keys_of_the_lines() {
        for (machine, namespace) in machines().iter().flat_map(|machine| ["/", "/cell_2"].map(|ns| (machine, ns))) {
            let elements = elements(&document(machine, namespace, 0));
            let ids: Vec<&String> = elements.iter().filter_map(|(_, _, attributes)| attributes.get("id")).collect();
            let unique: BTreeSet<&String> = ids.iter().copied().collect();
            assert_eq!(ids.len(), unique.len(), "an id is used twice: {ids:?}");
            let items: BTreeSet<String> = elements
                .iter()
                .filter(|(_, name, _)| name == "DataItem")
                .map(|(_, _, attributes)| attributes["id"].clone())
                .collect();
            let cell = CellMessages { equipment: Equipment::of_machine(machine), ..CellMessages::default() };
            let lines = changes(None, &read_all(&cell), true, &id_prefix(namespace), 0);
            let mut keys = BTreeSet::new();
            for line in lines.lines() {
                let fields: Vec<&str> = line.split('|').skip(1).collect();
                let is_condition = fields.len() == 6 && fields[1] == "UNAVAILABLE" && fields[2].is_empty();
                let step = if is_condition { 6 } else { 2 };
                keys.extend(fields.chunks(step).map(|fields| fields[0].to_owned()));
            }
            assert_eq!(items, keys, "{} in {namespace}", machine.name);
        }
    }

    #[test]
    fn the_device_model_uses_names_of_the_published_model() {
        for machine in machines() {
            let text = document(&machine, "/", 0);
            for (parent, name, attributes) in elements(&text) {
                let attribute = |name: &str| attributes.get(name).map_or("", String::as_str);
                if name != "DataItem" {
                    let is_list = ["MTConnectDevices", "Header", "Devices", "Description", "Components", "DataItems"];
                    let is_known = is_list.contains(&name.as_str()) || COMPONENTS.contains(&name.as_str());
                    assert!(is_known, "{name} in {parent}");
                    continue;
                }
                let known = MODEL.iter().find(|(kind, ..)| *kind == attribute("type"));
                let (kind, category, sub_types, units) = known.unwrap_or_else(|| panic!("{attributes:?}"));
                assert_eq!((attribute("category"), attribute("units")), (*category, *units), "{kind}");
                let sub_type = attribute("subType");
                let is_right = if sub_types.is_empty() { sub_type.is_empty() } else { sub_types.contains(&sub_type) };
                assert!(is_right, "{kind} {sub_type}");
            }
        }
        // Every sample has units, and every row of the table is in use.
        assert!(ITEMS.iter().all(|item| (item.category == Category::Sample) == item.units.is_some()));
        assert!(MODEL.iter().all(|(kind, ..)| ITEMS.iter().any(|item| item.kind == *kind)));
    }

    #[test]
    fn the_equipment_decides_about_components() {
        let has =
            |machine: &MachineDescription, element: &str| document(machine, "/", 0).contains(&format!("<{element} "));
        let (grinder, lathe) = (machine("cam_grinder.yaml", &[]), machine("lathe.yaml", &[]));
        assert!(!has(&grinder, "Door") && !has(&grinder, "Chuck"));
        let loaded = machine("cam_grinder.yaml", &[LOADING]);
        assert!(has(&loaded, "Door") && has(&loaded, "Chuck"));
        let rotary = |machine| document(machine, "/", 0).matches("<Rotary ").count();
        assert_eq!((rotary(&grinder), rotary(&lathe)), (2, 1), "a lathe has no wheel");
        let text = document(&grinder, "/hall/cell_2", 1_760_000_000_000_000_000);
        assert!(text.contains("<Device id=\"hall_cell_2_device\" name=\"hall_cell_2\" uuid=\"camwright_hall_cell_2\""));
        assert!(text.contains("creationTime=\"2025-10-09T08:53:20.000Z\""), "{text}");
        assert_eq!(escaped("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
