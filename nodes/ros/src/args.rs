// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `--ros-args`, as rcl reads it, and the environment.

use std::path::Path;

use super::{
    level::Level,
    loopback::IntraProcess,
    names::{self, NameKind, RemapRule, RemapTarget},
    parameter_value::ParameterValue,
    params_file::{self, NodeParameters},
    unsupported::Unsupported,
};

/// A command line or an environment that cannot be meant. Programs print it and exit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ArgsError {
    /// A flag without its value.
    #[error("{flag} needs a value")]
    MissingValue { flag: String },
    /// A value that breaks its grammar.
    #[error("{flag} {value}: {reason}")]
    Malformed { flag: String, value: String, reason: String },
    /// A parameter file that cannot be read.
    #[error("parameter file {path}: {reason}")]
    ParamsFile {
        /// The file, with the line if one is at fault.
        path: String,
        reason: String,
    },
    /// A token after `--ros-args` that is not an argument of ROS; rclcpp and rclpy end on it too.
    #[error(
        "unknown ROS argument {token:?}{}; after `--ros-args`: {FLAGS}; arguments of the program go before `--ros-args` or after `--`",
        suggestion(token)
    )]
    Unknown { token: String },
    /// An environment variable that cannot be meant.
    #[error("environment variable {variable}={value}: {reason}")]
    Environment { variable: String, value: String, reason: String },
}

/// Arguments of ROS, for the error about an unknown one.
const FLAGS: &str = "-r FROM:=TO, -p NAME:=VALUE, --params-file FILE, --log-level LEVEL";

/// Flag that a rule without one needs.
fn suggestion(token: &str) -> String {
    if token.contains(":=") && !token.starts_with('-') {
        return format!("; did you mean `-r {token}` or `-p {token}`?");
    }
    String::new()
}

/// Which hosts may find this one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DiscoveryRange {
    /// Only this one (the default here): nothing leaves the loopback interface.
    #[default]
    Localhost,
    /// All that multicast reaches.
    Subnet,
}

/// Parameter overrides in the order of the command line; later ones win.
#[derive(Debug, Clone, PartialEq)]
enum Override {
    One { node: Option<String>, name: String, value: ParameterValue },
    File(Vec<NodeParameters>),
}

/// Arguments and environment variables of ROS 2, shared by the nodes of a process.
#[derive(Debug, Clone, PartialEq)]
pub struct RosArgs {
    remaps: Vec<RemapRule>,
    overrides: Vec<Override>,
    log_levels: Vec<(String, Level)>,
    default_level: Option<Level>,
    enclave: Option<String>,
    stdout_logs: bool,
    lowest_stdout: Level,
    rosout_logs: bool,
    unparsed: Vec<String>,
    domain_id: u16,
    range: DiscoveryRange,
    namespace: String,
    unsupported: Unsupported,
    process: Option<IntraProcess>,
}

impl Default for RosArgs {
    fn default() -> Self {
        RosArgs {
            remaps: Vec::new(),
            overrides: Vec::new(),
            log_levels: Vec::new(),
            default_level: None,
            enclave: None,
            stdout_logs: true,
            lowest_stdout: Level::Unset,
            rosout_logs: true,
            unparsed: Vec::new(),
            domain_id: 0,
            range: DiscoveryRange::Localhost,
            namespace: "/".into(),
            unsupported: Unsupported::default(),
            process: None,
        }
    }
}

impl RosArgs {
    /// Largest domain id: its last ports are below 65536.
    pub const LAST_DOMAIN: u16 = 232;

    /// Reads this process's arguments and environment. Returns what is not ROS's, without the program's name.
    ///
    /// # Errors
    /// Anything malformed: programs exit on it, as ROS 2's do.
    pub fn from_env() -> Result<(Self, Vec<String>), ArgsError> {
        let args: Vec<String> =
            std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect();
        Self::parse(&args)
    }

    /// Reads the given arguments and this process's environment.
    ///
    /// # Errors
    /// See [`RosArgs::from_env`].
    pub fn parse(args: &[String]) -> Result<(Self, Vec<String>), ArgsError> {
        let (ros, rest) =
            Self::parse_with(args, |variable| std::env::var(variable).ok().filter(|value| !value.is_empty()))?;
        match ros.unparsed.first() {
            Some(token) => Err(ArgsError::Unknown { token: token.clone() }),
            None => Ok((ros, rest)),
        }
    }

    /// Reads the given arguments and variables. As in rcl, unknown tokens are left: see [`RosArgs::unparsed`].
    ///
    /// # Errors
    /// See [`RosArgs::from_env`].
    pub fn parse_with(
        args: &[String],
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<(Self, Vec<String>), ArgsError> {
        let mut ros = RosArgs::default();
        ros.read_environment(&variable)?;
        let mut rest = Vec::new();
        let mut args = args.iter();
        let mut inside = false;
        while let Some(argument) = args.next() {
            match (inside, argument.as_str()) {
                (_, "--ros-args") => inside = true,
                (true, "--") => inside = false,
                (true, flag) => ros.read_flag(flag, &mut args)?,
                (false, other) => rest.push(other.to_string()),
            }
        }
        ros.unsupported = Unsupported::read(&variable, ros.enclave.as_deref());
        Ok((ros, rest))
    }

    fn read_environment(&mut self, variable: impl Fn(&str) -> Option<String>) -> Result<(), ArgsError> {
        let refuse = |name: &str, value: &str, reason: &str| {
            Err(ArgsError::Environment { variable: name.into(), value: value.into(), reason: reason.into() })
        };
        if let Some(value) = variable("ROS_DOMAIN_ID") {
            match value.parse::<u16>() {
                Ok(id) if id <= Self::LAST_DOMAIN => self.domain_id = id,
                _ => return refuse("ROS_DOMAIN_ID", &value, "is not a domain id from 0 to 232"),
            }
        }
        if let Some(value) = variable("ROS_AUTOMATIC_DISCOVERY_RANGE") {
            self.range = match value.as_str() {
                "LOCALHOST" => DiscoveryRange::Localhost,
                "SUBNET" | "SYSTEM_DEFAULT" => DiscoveryRange::Subnet,
                "OFF" => {
                    return refuse("ROS_AUTOMATIC_DISCOVERY_RANGE", &value, "is not supported here; use LOCALHOST");
                }
                _ => return refuse("ROS_AUTOMATIC_DISCOVERY_RANGE", &value, "is not LOCALHOST or SUBNET"),
            };
        }
        if let Some(value) = variable("ROS_LOCALHOST_ONLY") {
            match value.as_str() {
                "1" => self.range = DiscoveryRange::Localhost,
                "0" => {}
                _ => return refuse("ROS_LOCALHOST_ONLY", &value, "is neither 0 nor 1"),
            }
        }
        if let Some(value) = variable("ROS_NAMESPACE") {
            let absolute = if value.starts_with('/') { value.clone() } else { format!("/{value}") };
            match names::check_namespace(&absolute) {
                Ok(()) => self.namespace = absolute,
                Err(error) => return refuse("ROS_NAMESPACE", &value, &error.reason),
            }
        }
        Ok(())
    }

    fn read_flag<'a>(&mut self, flag: &str, args: &mut impl Iterator<Item = &'a String>) -> Result<(), ArgsError> {
        let mut value = || args.next().map(String::as_str).ok_or_else(|| ArgsError::MissingValue { flag: flag.into() });
        let malformed =
            |value: &str, reason: String| ArgsError::Malformed { flag: flag.into(), value: value.into(), reason };
        match flag {
            "-r" | "--remap" => {
                let text = value()?;
                self.remaps.push(remap_rule(text).map_err(|reason| malformed(text, reason))?);
            }
            "-p" | "--param" => {
                let text = value()?;
                self.overrides.push(param_rule(text).map_err(|reason| malformed(text, reason))?);
            }
            "--params-file" => {
                let path = value()?;
                let entries = params_file::read(Path::new(path))
                    .map_err(|reason| ArgsError::ParamsFile { path: path.into(), reason })?;
                self.overrides.push(Override::File(entries));
            }
            "--log-level" => {
                let text = value()?;
                let (logger, level) = match text.split_once(":=") {
                    Some((logger, level)) => (Some(logger), level),
                    None => (None, text),
                };
                let level = Level::from_name(level)
                    .ok_or_else(|| malformed(text, "is not debug, info, warn, error, fatal or unset".into()))?;
                match logger {
                    None => self.default_level = Some(level),
                    Some("") => return Err(malformed(text, "the name of the logger is empty".into())),
                    Some(logger) => self.log_levels.push((logger.to_string(), level)),
                }
            }
            "-e" | "--enclave" => {
                let text = value()?;
                names::check_namespace(text).map_err(|error| malformed(text, error.reason))?;
                self.enclave = Some(text.to_string());
            }
            // Log files are not written: the console, /rosout and the bag have it all. The flags are accepted as rcl's are.
            "--log-config-file" | "--log-file-name" => {
                value()?;
            }
            "--enable-stdout-logs" => self.stdout_logs = true,
            "--disable-stdout-logs" => self.stdout_logs = false,
            "--enable-rosout-logs" => self.rosout_logs = true,
            "--disable-rosout-logs" => self.rosout_logs = false,
            "--enable-external-lib-logs" | "--disable-external-lib-logs" => {}
            other => self.unparsed.push(other.to_string()),
        }
        Ok(())
    }

    /// Tokens inside `--ros-args` that mean nothing to ROS. rcl leaves them; [`RosArgs::parse`] refuses them, as rclcpp and rclpy do.
    pub fn unparsed(&self) -> &[String] {
        &self.unparsed
    }

    pub fn domain_id(&self) -> u16 {
        self.domain_id
    }

    /// The same in another domain.
    #[must_use]
    pub fn with_domain_id(mut self, domain_id: u16) -> Self {
        self.domain_id = domain_id;
        self
    }

    /// The same with one more parameter override, which wins over all before it; `node` as in `node:name:=value`.
    #[must_use]
    pub fn with_parameter(mut self, node: Option<&str>, name: &str, value: ParameterValue) -> Self {
        self.overrides.push(Override::One { node: node.map(str::to_string), name: name.to_string(), value });
        self
    }

    /// The same with a value for the default of a parameter.
    #[must_use]
    pub fn with_default_parameter(mut self, node: Option<&str>, name: &str, value: ParameterValue) -> Self {
        self.overrides.insert(0, Override::One { node: node.map(str::to_string), name: name.to_string(), value });
        self
    }

    /// The same with a namespace for all nodes without a rule of their own.
    #[must_use]
    pub fn with_namespace(mut self, namespace: &str) -> Self {
        self.namespace = namespace.to_string();
        self
    }

    /// Which hosts may find this one.
    pub fn discovery_range(&self) -> DiscoveryRange {
        self.range
    }

    /// Security enclave, if one was named (security itself is not supported).
    pub fn enclave(&self) -> Option<&str> {
        self.enclave.as_deref()
    }

    pub(super) fn unsupported(&self) -> &Unsupported {
        &self.unsupported
    }

    pub(super) fn default_namespace(&self) -> &str {
        &self.namespace
    }

    pub(super) fn remap_rules(&self) -> &[RemapRule] {
        &self.remaps
    }

    /// Lets the nodes that are started with these arguments and their clones deliver topics to each other without the network.
    #[must_use]
    pub fn with_intra_process(mut self) -> Self {
        self.process = Some(IntraProcess::default());
        self
    }

    pub(super) fn intra_process(&self) -> Option<&IntraProcess> {
        self.process.as_ref()
    }

    /// Prints only lines from this level on the terminal, unless the command line sets a log level. `/rosout` keeps every line.
    #[must_use]
    pub fn with_console_level(mut self, lowest: Level) -> Self {
        let is_set = !self.log_levels.is_empty() || self.default_level.is_some();
        self.lowest_stdout = if is_set { Level::Unset } else { lowest };
        self
    }

    /// Lowest level that the terminal shows; none without a terminal log.
    pub(super) fn console(&self) -> Option<Level> {
        self.stdout_logs.then_some(self.lowest_stdout)
    }

    pub(super) fn rosout(&self) -> bool {
        self.rosout_logs
    }

    /// Level of a logger: the last rule for its name or a parent's (`a` for `a.b`), else the default, else info.
    pub(super) fn level_of(&self, logger: &str) -> Level {
        let applies =
            |name: &str| logger == name || logger.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
        let longest =
            self.log_levels.iter().filter(|(name, _)| applies(name)).max_by_key(|(name, _)| name.len()).map(|(n, _)| n);
        longest
            .and_then(|longest| self.log_levels.iter().rev().find(|(name, _)| name == longest))
            .map(|(_, level)| *level)
            .or(self.default_level)
            .filter(|level| *level != Level::Unset)
            .unwrap_or(Level::Info)
    }

    /// Overrides for a node, in the order they were given: later ones win. `explicit` is true if the node was named, so that an
    /// unknown name is an error.
    pub(super) fn overrides_for(&self, node: &str, fully_qualified: &str) -> Vec<NodeOverride> {
        let mut all = Vec::new();
        for item in &self.overrides {
            match item {
                Override::One { node: only, name, value } => {
                    if only.as_deref().is_none_or(|only| only == node) {
                        all.push(NodeOverride { name: name.clone(), value: value.clone(), explicit: only.is_some() });
                    }
                }
                Override::File(entries) => {
                    for entry in entries.iter().filter(|entry| entry.applies_to(fully_qualified)) {
                        all.extend(entry.parameters.iter().map(|(name, value)| NodeOverride {
                            name: name.clone(),
                            value: value.clone(),
                            explicit: !entry.has_wildcard(),
                        }));
                    }
                }
            }
        }
        all
    }
}

/// One parameter override that applies to a node.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NodeOverride {
    pub(super) name: String,
    pub(super) value: ParameterValue,
    pub(super) explicit: bool,
}

/// `[node:]name:=yaml`.
fn param_rule(text: &str) -> Result<Override, String> {
    let (left, right) = text.split_once(":=").ok_or("is not of the form name:=value")?;
    let (node, name) = match left.split_once(':') {
        Some((node, name)) => {
            names::check_node_name(node).map_err(|error| error.to_string())?;
            (Some(node.to_string()), name)
        }
        None => (None, left),
    };
    let name_character = |c: char| c.is_ascii_alphanumeric() || "_./".contains(c);
    let group = |part: &str| !part.is_empty() && part.chars().all(name_character);
    if !name.split('.').all(group) || name.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(format!("'{name}' is not a parameter name"));
    }
    if name.starts_with("__") {
        return Err(format!("'{name}' is a remapping, not a parameter"));
    }
    if right.trim().is_empty() {
        return Err("has no value".into());
    }
    let value = params_file::parse_value(right)?;
    Ok(Override::One { node, name: name.to_string(), value })
}

/// `[node:][rostopic://|rosservice://]from:=to`.
fn remap_rule(text: &str) -> Result<RemapRule, String> {
    let (left, to) = text.split_once(":=").ok_or("is not of the form from:=to")?;
    if to.is_empty() {
        return Err("the text right of ':=' is missing".into());
    }
    let urls = [("rostopic://", NameKind::Topic), ("rosservice://", NameKind::Service)];
    let url = |text: &str| urls.iter().find_map(|(url, kind)| Some((*kind, text.strip_prefix(url)?.to_string())));
    let (node, (kind, from)) = match url(left) {
        Some((kind, from)) => (None, (Some(kind), from)),
        None => {
            let (node, from) = match left.split_once(':') {
                Some((node, from)) => {
                    names::check_node_name(node).map_err(|error| error.to_string())?;
                    (Some(node.to_string()), from)
                }
                None => (None, left),
            };
            (node, url(from).map_or((None, from.to_string()), |(kind, from)| (Some(kind), from)))
        }
    };
    if from.is_empty() {
        return Err("the text left of ':=' is missing".into());
    }
    let target = match (kind, from.as_str()) {
        (None, "__node" | "__name") => {
            names::check_node_name(to).map_err(|error| error.to_string())?;
            RemapTarget::NodeName
        }
        (None, "__ns") => {
            names::check_namespace(to).map_err(|error| error.to_string())?;
            RemapTarget::Namespace
        }
        _ => {
            for name in [from.as_str(), to] {
                // rcl's grammar of rules has neither substitutions nor the node's bare namespace.
                if name == "~" || name.contains(['{', '}']) {
                    return Err(format!("'{name}' is not a name that can be remapped"));
                }
                // Any node will do: both sides are expanded again for the node they are applied to.
                names::expand(name, "node", "/").map_err(|error| error.to_string())?;
            }
            RemapTarget::Name { kind, from }
        }
    };
    Ok(RemapRule { node, target, to: to.to_string() })
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
