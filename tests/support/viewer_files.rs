// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Checks of the display files for `RViz` and Foxglove against what both programs accept and what the cell publishes.
//!
//! Properties of `RViz` are those of its default plugins; properties of Foxglove's panels are those of the layout classes of
//! `foxglove-sdk`; message paths follow Foxglove's message path syntax.
#![allow(dead_code, reason = "each test binary uses its own part of this module")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use camwright_msgs::{FieldInfo, by_type_name};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A topic that the cell publishes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PublishedTopic {
    pub type_name: String,
    /// True if late subscribers receive the last messages; `None` if this is unknown.
    pub is_latched: Option<bool>,
}

pub type Published = BTreeMap<String, PublishedTopic>;

/// Accepted values of a property.
enum Kind {
    Text,
    Number,
    Bool,
    /// Red, green and blue, as `RViz` writes them.
    Colour,
    /// `#rrggbb`, with or without opacity.
    HexColour,
    /// Nothing.
    Empty,
    /// Checked by another table.
    Anything,
    Numbers(usize),
    OneOf(&'static [&'static str]),
    Keys(&'static [(&'static str, Kind)]),
    /// Names chosen by the user, each with a value of one kind.
    Named(&'static Kind),
    List(&'static Kind),
}

type Keys = &'static [(&'static str, Kind)];

fn check_kind(at: &str, kind: &Kind, value: &Value, faults: &mut Vec<String>) {
    let is_byte = |text: &str| text.trim().parse::<u8>().is_ok();
    let is_right = match kind {
        Kind::Anything => true,
        Kind::Text => value.is_string(),
        Kind::Number => value.is_number(),
        Kind::Bool => value.is_boolean(),
        Kind::Empty => value.is_null(),
        Kind::Colour => value.as_str().is_some_and(|text| text.split(';').count() == 3 && text.split(';').all(is_byte)),
        Kind::HexColour => value.as_str().and_then(|text| text.strip_prefix('#')).is_some_and(|digits| {
            [6, 8].contains(&digits.len()) && digits.chars().all(|digit| digit.is_ascii_hexdigit())
        }),
        Kind::Numbers(count) => {
            value.as_array().is_some_and(|values| values.len() == *count && values.iter().all(Value::is_number))
        }
        Kind::OneOf(names) => value.as_str().is_some_and(|text| names.contains(&text)),
        Kind::Keys(keys) => return check_keys(at, &[keys], value, faults),
        Kind::Named(kind) => {
            for (key, value) in value.as_object().into_iter().flatten() {
                check_kind(&format!("{at}/{key}"), kind, value, faults);
            }
            value.is_object()
        }
        Kind::List(kind) => {
            for (index, value) in value.as_array().into_iter().flatten().enumerate() {
                check_kind(&format!("{at}/{index}"), kind, value, faults);
            }
            value.is_array()
        }
    };
    if !is_right {
        faults.push(format!("{at}: {value} is not accepted"));
    }
}

fn check_keys(at: &str, tables: &[Keys], value: &Value, faults: &mut Vec<String>) {
    let Some(object) = value.as_object() else {
        faults.push(format!("{at}: {value} has no properties"));
        return;
    };
    for (key, value) in object {
        match tables.iter().flat_map(|table| table.iter()).find(|(name, _)| name == key) {
            Some((_, kind)) => check_kind(&format!("{at}/{key}"), kind, value, faults),
            None => faults.push(format!("{at}: {key} is not a property")),
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------- RViz

const XYZ: Keys = &[("X", Kind::Number), ("Y", Kind::Number), ("Z", Kind::Number)];

const TOPIC: Keys = &[
    ("Depth", Kind::Number),
    ("Durability Policy", Kind::OneOf(&["System Default", "Volatile", "Transient Local"])),
    ("Filter size", Kind::Number),
    ("History Policy", Kind::OneOf(&["System Default", "Keep Last", "Keep All"])),
    ("Reliability Policy", Kind::OneOf(&["System Default", "Reliable", "Best Effort"])),
    ("Value", Kind::Text),
];

/// Properties of every display.
const DISPLAY: Keys = &[("Class", Kind::Text), ("Name", Kind::Text), ("Enabled", Kind::Bool), ("Value", Kind::Bool)];

/// A display: its class, properties, property of its topic, and type of its messages.
struct RvizDisplay {
    class: &'static str,
    keys: Keys,
    topic: Option<(&'static str, &'static str)>,
}

const DISPLAYS: [RvizDisplay; 4] = [
    RvizDisplay {
        class: "rviz_default_plugins/Grid",
        keys: &[
            ("Alpha", Kind::Number),
            ("Cell Size", Kind::Number),
            ("Color", Kind::Colour),
            (
                "Line Style",
                Kind::Keys(&[("Line Width", Kind::Number), ("Value", Kind::OneOf(&["Lines", "Billboards"]))]),
            ),
            ("Normal Cell Count", Kind::Number),
            ("Offset", Kind::Keys(XYZ)),
            ("Plane", Kind::OneOf(&["XY", "XZ", "YZ"])),
            ("Plane Cell Count", Kind::Number),
            ("Reference Frame", Kind::Text),
        ],
        topic: None,
    },
    RvizDisplay {
        class: "rviz_default_plugins/RobotModel",
        keys: &[
            ("Alpha", Kind::Number),
            ("Collision Enabled", Kind::Bool),
            ("Description File", Kind::Text),
            ("Description Source", Kind::OneOf(&["Topic", "File"])),
            ("Description Topic", Kind::Keys(TOPIC)),
            (
                "Links",
                Kind::Keys(&[
                    ("All Links Enabled", Kind::Bool),
                    ("Expand Joint Details", Kind::Bool),
                    ("Expand Link Details", Kind::Bool),
                    ("Expand Tree", Kind::Bool),
                    (
                        "Link Tree Style",
                        Kind::OneOf(&[
                            "",
                            "Links in Alphabetic Order",
                            "Joints in Alphabetic Order",
                            "Tree of links",
                            "Tree of links and joints",
                        ]),
                    ),
                ]),
            ),
            ("Mass Properties", Kind::Keys(&[("Inertia", Kind::Bool), ("Mass", Kind::Bool)])),
            ("TF Prefix", Kind::Text),
            ("Update Interval", Kind::Number),
            ("Visual Enabled", Kind::Bool),
        ],
        topic: Some(("Description Topic", "std_msgs/msg/String")),
    },
    RvizDisplay {
        class: "rviz_default_plugins/MarkerArray",
        keys: &[("Namespaces", Kind::Named(&Kind::Bool)), ("Topic", Kind::Keys(TOPIC))],
        topic: Some(("Topic", "visualization_msgs/msg/MarkerArray")),
    },
    RvizDisplay {
        class: "rviz_default_plugins/TF",
        keys: &[
            ("Filter (blacklist)", Kind::Text),
            ("Filter (whitelist)", Kind::Text),
            ("Frame Timeout", Kind::Number),
            ("Frames", Kind::Keys(&[("All Enabled", Kind::Bool)])),
            ("Marker Scale", Kind::Number),
            ("Show Arrows", Kind::Bool),
            ("Show Axes", Kind::Bool),
            ("Show Names", Kind::Bool),
            ("Tree", Kind::Named(&Kind::Text)),
            ("Update Interval", Kind::Number),
        ],
        topic: None,
    },
];

const PANELS: [(&str, Keys); 3] = [
    (
        "rviz_common/Displays",
        &[
            ("Class", Kind::Text),
            ("Help Height", Kind::Number),
            ("Name", Kind::Text),
            ("Property Tree Widget", Kind::Keys(&[("Expanded", Kind::Empty), ("Splitter Ratio", Kind::Number)])),
            ("Tree Height", Kind::Number),
        ],
    ),
    (
        "rviz_common/Views",
        &[("Class", Kind::Text), ("Name", Kind::Text), ("Expanded", Kind::Empty), ("Splitter Ratio", Kind::Number)],
    ),
    (
        "rviz_common/Time",
        &[
            ("Class", Kind::Text),
            ("Name", Kind::Text),
            ("Experimental", Kind::Bool),
            ("SyncMode", Kind::Number),
            ("SyncSource", Kind::Text),
        ],
    ),
];

const TOOLS: [(&str, Keys); 5] = [
    ("rviz_default_plugins/Interact", &[("Class", Kind::Text), ("Hide Inactive Objects", Kind::Bool)]),
    ("rviz_default_plugins/MoveCamera", &[("Class", Kind::Text)]),
    ("rviz_default_plugins/Select", &[("Class", Kind::Text)]),
    ("rviz_default_plugins/FocusCamera", &[("Class", Kind::Text)]),
    ("rviz_default_plugins/Measure", &[("Class", Kind::Text), ("Line color", Kind::Colour)]),
];

const VIEWS: [(&str, Keys); 1] = [(
    "rviz_default_plugins/Orbit",
    &[
        ("Class", Kind::Text),
        ("Name", Kind::Text),
        ("Distance", Kind::Number),
        (
            "Enable Stereo Rendering",
            Kind::Keys(&[
                ("Stereo Eye Separation", Kind::Number),
                ("Stereo Focal Distance", Kind::Number),
                ("Swap Stereo Eyes", Kind::Bool),
                ("Value", Kind::Bool),
            ]),
        ),
        ("Focal Point", Kind::Keys(XYZ)),
        ("Focal Shape Fixed Size", Kind::Bool),
        ("Focal Shape Size", Kind::Number),
        ("Invert Z Axis", Kind::Bool),
        ("Near Clip Distance", Kind::Number),
        ("Pitch", Kind::Number),
        ("Target Frame", Kind::Text),
        ("Value", Kind::Text),
        ("Yaw", Kind::Number),
    ],
)];

const TRANSFORMERS: [(&str, Keys); 1] = [("rviz_default_plugins/TF", &[("Class", Kind::Text)])];

/// Checks things of a class against a table.
fn check_class(at: &str, table: &[(&str, Keys)], value: &Value, faults: &mut Vec<String>) {
    let class = value["Class"].as_str().unwrap_or_default();
    match table.iter().find(|(known, _)| *known == class) {
        Some((_, keys)) => check_keys(&format!("{at} {class}"), &[keys], value, faults),
        None => faults.push(format!("{at}: class {:?} is unknown", value["Class"])),
    }
}

fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

/// Faults of a display file of `RViz`. Its topics are relative to the namespace of the cell; `namespaces` are those of the markers.
pub fn rviz_faults(text: &str, published: &Published, namespaces: &BTreeSet<String>) -> Vec<String> {
    let root: Value = match serde_saphyr::from_str(text) {
        Ok(root) => root,
        Err(error) => return vec![format!("not YAML: {error}")],
    };
    let mut faults = Vec::new();
    check_keys(
        "file",
        &[&[
            ("Panels", Kind::Anything),
            ("Visualization Manager", Kind::Anything),
            (
                "Window Geometry",
                Kind::Keys(&[
                    ("Displays", Kind::Keys(&[("collapsed", Kind::Bool)])),
                    ("Height", Kind::Number),
                    ("Width", Kind::Number),
                ]),
            ),
        ]],
        &root,
        &mut faults,
    );
    items(&root["Panels"]).for_each(|panel| check_class("panel", &PANELS, panel, &mut faults));
    let manager = &root["Visualization Manager"];
    for key in manager.as_object().into_iter().flat_map(|manager| manager.keys()) {
        let known =
            ["Class", "Displays", "Enabled", "Global Options", "Name", "Tools", "Transformation", "Value", "Views"];
        if !known.contains(&key.as_str()) {
            faults.push(format!("Visualization Manager: {key} is not a property"));
        }
    }
    let options: Keys =
        &[("Background Color", Kind::Colour), ("Fixed Frame", Kind::Text), ("Frame Rate", Kind::Number)];
    check_keys("Global Options", &[options], &manager["Global Options"], &mut faults);
    items(&manager["Tools"]).for_each(|tool| check_class("tool", &TOOLS, tool, &mut faults));
    check_class("view", &VIEWS, &manager["Views"]["Current"], &mut faults);
    check_class("transformation", &TRANSFORMERS, &manager["Transformation"]["Current"], &mut faults);
    if items(&manager["Displays"]).count() == 0 {
        faults.push("the file has no displays".into());
    }
    for display in items(&manager["Displays"]) {
        let at = format!("display {}", display["Name"]);
        let class = display["Class"].as_str().unwrap_or_default();
        let Some(known) = DISPLAYS.iter().find(|known| known.class == class) else {
            faults.push(format!("{at}: class {:?} is unknown", display["Class"]));
            continue;
        };
        check_keys(&at, &[DISPLAY, known.keys], display, &mut faults);
        if let Some((key, type_name)) = known.topic {
            faults.extend(topic_fault(&display[key], type_name, published).map(|fault| format!("{at}: {fault}")));
        }
        for name in display["Namespaces"].as_object().into_iter().flat_map(|names| names.keys()) {
            if !namespaces.contains(name) {
                faults.push(format!("{at}: no marker has the namespace {name}"));
            }
        }
    }
    faults
}

fn topic_fault(topic: &Value, type_name: &str, published: &Published) -> Option<String> {
    let name = topic["Value"].as_str().unwrap_or_default();
    let Some(found) = published.get(&format!("/{}", name.trim_start_matches('/'))) else {
        return Some(format!("the topic {name:?} is not published"));
    };
    if name.starts_with('/') {
        return Some(format!("the topic {name} is not relative to the namespace of the cell"));
    }
    if found.type_name != type_name {
        return Some(format!("{name} has {}, the display shows {type_name}", found.type_name));
    }
    let wants_last = topic["Durability Policy"] == "Transient Local";
    match found.is_latched {
        Some(false) if wants_last => Some(format!("{name} is volatile: Transient Local receives nothing")),
        Some(true) if !wants_last => Some(format!("{name} is latched: Volatile misses the last message")),
        _ => None,
    }
}

// ------------------------------------------------------------------------------------------------------------ Foxglove

/// Functions of message paths, with the least and the largest number of their arguments.
const FUNCTIONS: [(&str, usize, usize); 17] = [
    ("abs", 0, 0),
    ("negative", 0, 0),
    ("sign", 0, 0),
    ("ceil", 0, 0),
    ("floor", 0, 0),
    ("trunc", 0, 0),
    ("round", 0, 1),
    ("sqrt", 0, 0),
    ("degrees", 0, 0),
    ("radians", 0, 0),
    ("wrap_angle", 0, 0),
    ("add", 1, 8),
    ("sub", 1, 8),
    ("mul", 1, 8),
    ("div", 1, 1),
    ("min", 1, 8),
    ("max", 1, 8),
];

/// A step of a message path behind its topic.
#[derive(Debug, Clone, PartialEq)]
pub enum PathStep {
    Field(String),
    Index(i64),
    Slice(Option<i64>, Option<i64>),
    Function(String, Vec<f64>),
}

/// Topic and steps of a message path.
///
/// # Errors
/// The part that does not follow the syntax. Filters and variables are not accepted: a layout of the cell needs none.
pub fn message_path(path: &str) -> Result<(String, Vec<PathStep>), String> {
    let end = path.find(['.', '[', '{']).unwrap_or(path.len());
    let (topic, mut rest) = path.split_at(end);
    let is_name = |name: &str| {
        name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if !topic.strip_prefix('/').is_some_and(|names| names.split('/').all(is_name)) {
        return Err(format!("{path}: {topic:?} is no topic"));
    }
    let mut steps = Vec::new();
    while !rest.is_empty() {
        if let Some(call) = rest.strip_prefix(".@") {
            let end = call.find(['.', '[', '(']).unwrap_or(call.len());
            let name = &call[..end];
            let (arguments, behind) = match call[end..].strip_prefix('(') {
                Some(list) => {
                    let (list, behind) = list.split_once(')').ok_or(format!("{path}: a parenthesis is open"))?;
                    let numbers = list.split(',').map(|number| number.trim().parse());
                    let numbers: Result<Vec<f64>, _> = numbers.collect();
                    (numbers.map_err(|_| format!("{path}: {list:?} are not numbers"))?, behind)
                }
                None => (Vec::new(), &call[end..]),
            };
            let known = FUNCTIONS.iter().find(|(known, ..)| *known == name);
            let (_, least, most) = known.ok_or(format!("{path}: the function {name} is unknown"))?;
            if !(*least..=*most).contains(&arguments.len()) {
                return Err(format!("{path}: {name} with {} arguments", arguments.len()));
            }
            steps.push(PathStep::Function(name.to_owned(), arguments));
            rest = behind;
        } else if let Some(field) = rest.strip_prefix('.') {
            let end = field.find(['.', '[', '{']).unwrap_or(field.len());
            if !is_name(&field[..end]) {
                return Err(format!("{path}: {:?} is no field", &field[..end]));
            }
            steps.push(PathStep::Field(field[..end].to_owned()));
            rest = &field[end..];
        } else if let Some(index) = rest.strip_prefix('[') {
            let (index, behind) = index.split_once(']').ok_or(format!("{path}: a bracket is open"))?;
            let number = |text: &str| text.parse::<i64>().map_err(|_| format!("{path}: {text:?} is no index"));
            steps.push(match index.split_once(':') {
                Some((from, to)) => {
                    let end = |text: &str| if text.is_empty() { Ok(None) } else { number(text).map(Some) };
                    PathStep::Slice(end(from)?, end(to)?)
                }
                None => PathStep::Index(number(index)?),
            });
            rest = behind;
        } else {
            return Err(format!("{path}: {rest:?} is not understood"));
        }
    }
    Ok((topic.to_owned(), steps))
}

/// Value at the end of a message path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PathValue {
    pub is_number: bool,
    pub is_list: bool,
}

/// Offsets of the constants of `FieldType` for arrays, bounded and unbounded sequences.
const OF_LISTS: u8 = 48;

/// `FieldType` numbers from `int8` to `long double`.
const NUMBERS: std::ops::RangeInclusive<u8> = 2..=12;

/// Follows a message path through the types of its topic.
///
/// # Errors
/// A topic that is not published, a field that its type has not, an index of something that is no list.
pub fn path_value(path: &str, published: &Published) -> Result<PathValue, String> {
    let (topic, steps) = message_path(path)?;
    let found = published.get(&topic).ok_or(format!("{path}: {topic} is not published"))?;
    let mut nested = Some(found.type_name.as_str());
    // Lists of the value that were not indexed, and those of its field.
    let (mut is_list, mut field): (bool, Option<&FieldInfo>) = (false, None);
    let mut is_open_list = false;
    for step in &steps {
        match step {
            PathStep::Field(name) => {
                if is_open_list {
                    return Err(format!("{path}: {name} of a list needs an index or a slice"));
                }
                let kind = nested.ok_or(format!("{path}: nothing has {name}"))?;
                let info = by_type_name(kind).ok_or(format!("{path}: the type {kind} is unknown"))?;
                let of = info.fields.iter().find(|field| field.name == name);
                let of = of.ok_or(format!("{path}: {kind} has no {name}"))?;
                nested = Some(of.nested_type_name).filter(|name| !name.is_empty());
                is_open_list = of.type_id >= OF_LISTS;
                field = Some(of);
            }
            PathStep::Index(_) | PathStep::Slice(..) => {
                if !is_open_list {
                    return Err(format!("{path}: an index of something that is no list"));
                }
                is_open_list = false;
                is_list |= matches!(step, PathStep::Slice(..));
            }
            PathStep::Function(name, _) => {
                if !field.is_some_and(|field| NUMBERS.contains(&(field.type_id % OF_LISTS))) || is_open_list {
                    return Err(format!("{path}: {name} of something that is no number"));
                }
            }
        }
    }
    let is_number = field.is_some_and(|field| NUMBERS.contains(&(field.type_id % OF_LISTS)));
    Ok(PathValue { is_number, is_list: is_list || is_open_list })
}

/// Properties of every panel.
const PANEL: Keys = &[("foxglovePanelTitle", Kind::Text)];

const SERIES: Keys = &[
    ("value", Kind::Text),
    ("label", Kind::Text),
    ("enabled", Kind::Bool),
    ("color", Kind::HexColour),
    ("timestampMethod", Kind::OneOf(&["receiveTime", "publishTime", "headerStamp", "customField"])),
    ("showLine", Kind::Bool),
    ("lineSize", Kind::Number),
];

const TOPIC_SETTINGS: Keys = &[("visible", Kind::Bool), ("drawBehind", Kind::Bool), ("frameLocked", Kind::Bool)];

const LAYER: Keys = &[
    ("instanceId", Kind::Text),
    ("layerId", Kind::OneOf(&["foxglove.Grid", "foxglove.Urdf"])),
    ("label", Kind::Text),
    ("visible", Kind::Bool),
    ("frameLocked", Kind::Bool),
    ("order", Kind::Number),
    ("frameId", Kind::Text),
    ("size", Kind::Number),
    ("divisions", Kind::Number),
    ("lineWidth", Kind::Number),
    ("color", Kind::HexColour),
    ("position", Kind::Numbers(3)),
    ("rotation", Kind::Numbers(3)),
    ("displayMode", Kind::OneOf(&["auto", "visual", "collision"])),
    ("sourceType", Kind::OneOf(&["url", "filePath", "param", "topic"])),
    ("topic", Kind::Text),
    ("framePrefix", Kind::Text),
];

const PANEL_TYPES: [(&str, Keys); 5] = [
    (
        "3D",
        &[
            ("followTf", Kind::Text),
            ("followMode", Kind::OneOf(&["follow-none", "follow-pose", "follow-position"])),
            (
                "scene",
                Kind::Keys(&[
                    ("enableStats", Kind::Bool),
                    ("backgroundColor", Kind::HexColour),
                    ("labelScaleFactor", Kind::Number),
                    (
                        "transforms",
                        Kind::Keys(&[
                            ("visible", Kind::Bool),
                            ("editable", Kind::Bool),
                            ("showLabel", Kind::Bool),
                            ("labelSize", Kind::Number),
                            ("axisSize", Kind::Number),
                            ("lineWidth", Kind::Number),
                        ]),
                    ),
                ]),
            ),
            (
                "cameraState",
                Kind::Keys(&[
                    ("distance", Kind::Number),
                    ("perspective", Kind::Bool),
                    ("phi", Kind::Number),
                    ("thetaOffset", Kind::Number),
                    ("target", Kind::Numbers(3)),
                    ("targetOffset", Kind::Numbers(3)),
                    ("targetOrientation", Kind::Numbers(4)),
                    ("fovy", Kind::Number),
                    ("near", Kind::Number),
                    ("far", Kind::Number),
                ]),
            ),
            ("transforms", Kind::Named(&Kind::Keys(TOPIC_SETTINGS))),
            ("topics", Kind::Named(&Kind::Keys(TOPIC_SETTINGS))),
            ("layers", Kind::Named(&Kind::Keys(LAYER))),
        ],
    ),
    (
        "Plot",
        &[
            ("paths", Kind::List(&Kind::Keys(SERIES))),
            ("minXValue", Kind::Number),
            ("maxXValue", Kind::Number),
            ("minYValue", Kind::Number),
            ("maxYValue", Kind::Number),
            ("showLegend", Kind::Bool),
            ("legendDisplay", Kind::OneOf(&["floating", "top", "left"])),
            ("showPlotValuesInLegend", Kind::Bool),
            ("showXAxisLabels", Kind::Bool),
            ("showYAxisLabels", Kind::Bool),
            ("isSynced", Kind::Bool),
            ("xAxisVal", Kind::OneOf(&["custom", "timestamp", "index", "currentCustom"])),
            ("xAxisLabel", Kind::Text),
            ("yAxisLabel", Kind::Text),
            ("followingViewWidth", Kind::Number),
            ("sidebarDimension", Kind::Number),
        ],
    ),
    (
        "Indicator",
        &[
            ("path", Kind::Text),
            ("style", Kind::OneOf(&["bulb", "background"])),
            ("fontSize", Kind::Number),
            ("fallbackColor", Kind::HexColour),
            ("fallbackLabel", Kind::Text),
            (
                "rules",
                Kind::List(&Kind::Keys(&[
                    ("operator", Kind::OneOf(&["=", "<", "<=", ">", ">="])),
                    ("rawValue", Kind::Text),
                    ("color", Kind::HexColour),
                    ("label", Kind::Text),
                ])),
            ),
        ],
    ),
    (
        "RawMessages",
        &[
            ("topicPath", Kind::Text),
            ("diffEnabled", Kind::Bool),
            ("diffMethod", Kind::OneOf(&["custom", "previous message"])),
            ("diffTopicPath", Kind::Text),
            ("showFullMessageForDiff", Kind::Bool),
            ("fontSize", Kind::Number),
        ],
    ),
    (
        "DiagnosticSummary",
        &[
            ("minLevel", Kind::Number),
            ("pinnedIds", Kind::List(&Kind::Text)),
            ("hardwareIdFilter", Kind::Text),
            ("topicToRender", Kind::Text),
            ("sortByLevel", Kind::Bool),
        ],
    ),
];

/// Types of messages that a 3-D panel draws.
const DRAWN: [&str; 2] = ["visualization_msgs/msg/MarkerArray", "std_msgs/msg/String"];

/// Faults of a Foxglove layout. `states` holds the values of the constants of a message type.
pub fn layout_faults(layout: &Value, published: &Published, states: impl Fn(&str) -> BTreeSet<String>) -> Vec<String> {
    let mut faults = Vec::new();
    let known = ["configById", "globalVariables", "userNodes", "playbackConfig", "layout"];
    for key in layout.as_object().into_iter().flat_map(|layout| layout.keys()) {
        if !known.contains(&key.as_str()) {
            faults.push(format!("layout: {key} is not a property"));
        }
    }
    let mut shown = Vec::new();
    panels_of(&layout["layout"], &mut shown, &mut faults);
    let Some(panels) = layout["configById"].as_object() else { return vec!["the layout has no panels".into()] };
    for id in &shown {
        if !panels.contains_key(id) {
            faults.push(format!("{id} is shown, but has no configuration"));
        }
    }
    for (id, config) in panels {
        match shown.iter().filter(|shown| *shown == id).count() {
            1 => {}
            count => faults.push(format!("{id} is shown {count} times")),
        }
        let kind = id.split('!').next().unwrap_or_default();
        let Some((_, keys)) = PANEL_TYPES.iter().find(|(name, _)| *name == kind) else {
            faults.push(format!("{id}: the panel type {kind} is unknown"));
            continue;
        };
        check_keys(id, &[PANEL, keys], config, &mut faults);
        let in_panel = match kind {
            "3D" => faults_of_scene(config, published),
            "Plot" => faults_of_plot(config, published),
            "Indicator" => faults_of_indicator(config, published, &states),
            "RawMessages" => {
                path_value(config["topicPath"].as_str().unwrap_or_default(), published).err().into_iter().collect()
            }
            _ => type_fault(&config["topicToRender"], &["diagnostic_msgs/msg/DiagnosticArray"], published)
                .into_iter()
                .collect(),
        };
        faults.extend(in_panel.into_iter().map(|fault| format!("{id}: {fault}")));
    }
    faults
}

/// Panels of the tree of a layout.
fn panels_of(node: &Value, into: &mut Vec<String>, faults: &mut Vec<String>) {
    if let Some(id) = node.as_str() {
        into.push(id.to_owned());
        return;
    }
    check_keys(
        "layout",
        &[&[
            ("direction", Kind::OneOf(&["row", "column"])),
            ("splitPercentage", Kind::Number),
            ("first", Kind::Anything),
            ("second", Kind::Anything),
        ]],
        node,
        faults,
    );
    if node["splitPercentage"].as_f64().is_some_and(|share| share <= 0.0 || share >= 100.0) {
        faults.push(format!("layout: a panel has {} % of the room", node["splitPercentage"]));
    }
    for side in ["first", "second"] {
        match &node[side] {
            Value::Null => faults.push(format!("layout: a split has no {side} panel")),
            panel => panels_of(panel, into, faults),
        }
    }
}

fn type_fault(topic: &Value, types: &[&str], published: &Published) -> Option<String> {
    let name = topic.as_str().unwrap_or_default();
    match published.get(name) {
        None => Some(format!("the topic {name:?} is not published")),
        Some(found) if !types.contains(&found.type_name.as_str()) => {
            Some(format!("{name} has {}, the panel shows {types:?}", found.type_name))
        }
        Some(_) => None,
    }
}

fn faults_of_scene(config: &Value, published: &Published) -> Vec<String> {
    let topics = config["topics"].as_object().into_iter().flat_map(|topics| topics.keys());
    let topics: Vec<Value> = topics.map(|name| name.as_str().into()).collect();
    let layers = config["layers"].as_object().into_iter().flat_map(|layers| layers.values());
    let of_layers = layers.filter(|layer| layer["layerId"] == "foxglove.Urdf").map(|layer| &layer["topic"]);
    let of_layers = of_layers.filter_map(|topic| type_fault(topic, &["std_msgs/msg/String"], published));
    topics.iter().filter_map(|topic| type_fault(topic, &DRAWN, published)).chain(of_layers).collect()
}

/// A plot over time shows numbers, a plot over the index lists of numbers; labels and axis name the unit of the workshop.
fn faults_of_plot(config: &Value, published: &Published) -> Vec<String> {
    let mut faults = Vec::new();
    let over_index = config["xAxisVal"] == "index";
    if items(&config["paths"]).count() == 0 {
        faults.push("the plot has no series".into());
    }
    for series in items(&config["paths"]) {
        let path = series["value"].as_str().unwrap_or_default();
        match path_value(path, published) {
            Err(fault) => faults.push(fault),
            Ok(value) if !value.is_number => faults.push(format!("{path} is no number")),
            Ok(value) if value.is_list != over_index => {
                faults.push(format!("{path} does not fit the axis of the plot"));
            }
            Ok(_) => faults.extend(unit_fault(path, series["label"].as_str().unwrap_or_default())),
        }
    }
    faults
}

/// Units in labels, and the functions of a path that give them from SI units.
const UNITS: [(&str, &str); 6] = [
    ("mm", ".@mul(1000)"),
    ("mm/s", ".@mul(1000)"),
    ("µm", ".@mul(1000000)"),
    ("deg", ".@degrees"),
    ("deg/s", ".@degrees"),
    ("0.001 deg", ".@degrees.@mul(1000)"),
];

fn unit_fault(path: &str, label: &str) -> Option<String> {
    let unit = label.rsplit_once(" (").and_then(|(_, unit)| unit.strip_suffix(')'));
    let functions = path.find(".@").map_or("", |at| &path[at..]);
    match unit.and_then(|unit| UNITS.iter().find(|(known, _)| *known == unit)) {
        None => Some(format!("the label {label:?} of {path} names no unit of the workshop")),
        Some((unit, wanted)) if *wanted != functions => Some(format!("{path} is not in {unit}")),
        Some(_) => None,
    }
}

/// An indicator has a rule for every value of its state.
fn faults_of_indicator(
    config: &Value,
    published: &Published,
    states: &impl Fn(&str) -> BTreeSet<String>,
) -> Vec<String> {
    let path = config["path"].as_str().unwrap_or_default();
    let value = match path_value(path, published) {
        Ok(value) => value,
        Err(fault) => return vec![fault],
    };
    let mut faults = Vec::new();
    if !value.is_number || value.is_list {
        faults.push(format!("{path} is no number"));
    }
    let rules: BTreeSet<String> =
        items(&config["rules"]).filter_map(|rule| rule["rawValue"].as_str().map(str::to_owned)).collect();
    let type_name = path.split('.').next().and_then(|topic| published.get(topic)).map(|found| found.type_name.as_str());
    let values = states(type_name.unwrap_or_default());
    if rules != values {
        faults.push(format!("rules for {rules:?}, the state has {values:?}"));
    }
    faults
}
