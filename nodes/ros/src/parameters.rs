// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parameters: declarations with ranges and descriptions, and the store that guards them.

use std::{
    collections::BTreeMap,
    fmt,
    sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError},
};

use super::{args::NodeOverride, error::RosError, introspection, parameter_value::ParameterValue};

/// Name of the parameter that selects simulated time.
pub(super) const USE_SIM_TIME: &str = "use_sim_time";

/// Name of the parameter by which nodes of Jazzy offer `~/get_type_description`.
pub(super) const START_TYPE_DESCRIPTION_SERVICE: &str = "start_type_description_service";

/// Bounds of a number; a step of 0 is any value between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterRange {
    /// For doubles, both ends included.
    Double {
        from: f64,
        to: f64,
        /// Distance of allowed values from `from` on.
        step: f64,
    },
    /// For integers, both ends included.
    Integer {
        from: i64,
        to: i64,
        /// Distance of allowed values from `from` on.
        step: u64,
    },
}

/// Declaration of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    pub(super) name: String,
    pub(super) default: ParameterValue,
    /// A value of the parameter's type: the default, unless that is "not set".
    pub(super) example: ParameterValue,
    pub(super) description: String,
    pub(super) constraints: String,
    pub(super) range: Option<ParameterRange>,
    /// Allowed values of a string; empty: all.
    pub(super) choices: Vec<String>,
    pub(super) read_only: bool,
}

/// Another name for [`Parameter`].
pub type ParameterDeclaration = Parameter;

impl Parameter {
    /// A parameter with a default, which gives it its type.
    pub fn new(name: &str, default: ParameterValue) -> Self {
        Parameter {
            name: name.to_string(),
            example: default.clone(),
            default,
            description: String::new(),
            constraints: String::new(),
            range: None,
            choices: Vec::new(),
            read_only: false,
        }
    }

    /// A parameter that is not set at first and may be unset again; `example` gives it its type.
    pub fn optional(name: &str, example: ParameterValue) -> Self {
        Parameter { example, ..Self::new(name, ParameterValue::NotSet) }
    }

    /// Returns true if the parameter may be unset.
    pub fn is_optional(&self) -> bool {
        self.default == ParameterValue::NotSet
    }

    pub fn bool(name: &str, default: bool) -> Self {
        Self::new(name, ParameterValue::Bool(default))
    }

    pub fn integer(name: &str, default: i64) -> Self {
        Self::new(name, ParameterValue::Integer(default))
    }

    pub fn double(name: &str, default: f64) -> Self {
        Self::new(name, ParameterValue::Double(default))
    }

    pub fn string(name: &str, default: &str) -> Self {
        Self::new(name, ParameterValue::String(default.to_string()))
    }

    /// An array of strings.
    pub fn string_array(name: &str, default: &[&str]) -> Self {
        Self::new(name, ParameterValue::StringArray(default.iter().map(ToString::to_string).collect()))
    }

    /// An array of integers.
    pub fn integer_array(name: &str, default: &[i64]) -> Self {
        Self::new(name, ParameterValue::IntegerArray(default.to_vec()))
    }

    /// An array of doubles.
    pub fn double_array(name: &str, default: &[f64]) -> Self {
        Self::new(name, ParameterValue::DoubleArray(default.to_vec()))
    }

    /// Sets the description, with the unit.
    #[must_use]
    pub fn describe(mut self, description: &str) -> Self {
        self.description = description.to_string();
        self
    }

    /// Describes a rule that a range cannot express. A validator enforces it.
    #[must_use]
    pub fn constraints(mut self, constraints: &str) -> Self {
        self.constraints = constraints.to_string();
        self
    }

    /// Sets the bounds of a double, both included, or of every element of an array.
    #[must_use]
    pub fn range(self, from: f64, to: f64) -> Self {
        self.range_with_step(from, to, 0.0)
    }

    /// Sets the bounds of a double, and the distance of allowed values.
    #[must_use]
    pub fn range_with_step(mut self, from: f64, to: f64, step: f64) -> Self {
        self.range = Some(ParameterRange::Double { from, to, step });
        self
    }

    /// Sets the bounds of an integer, both included, or of every element of an array.
    #[must_use]
    pub fn integer_range(mut self, from: i64, to: i64) -> Self {
        self.range = Some(ParameterRange::Integer { from, to, step: 0 });
        self
    }

    /// Sets the bounds of an integer, and the distance of allowed values.
    #[must_use]
    pub fn integer_range_with_step(mut self, from: i64, to: i64, step: u64) -> Self {
        self.range = Some(ParameterRange::Integer { from, to, step });
        self
    }

    /// Sets the allowed values of a string.
    #[must_use]
    pub fn choices(mut self, choices: &[&str]) -> Self {
        self.choices = choices.iter().map(ToString::to_string).collect();
        self.constraints = format!("one of {}", choices.join(", "));
        self
    }

    /// Forbids changes after the start.
    #[must_use]
    pub fn read_only(mut self) -> Self {
        self.read_only = true;
        self
    }

    /// Checks type and range of a value as a parameter file or a command line gives it.
    ///
    /// # Errors
    /// The end of a sentence that begins with the parameter.
    pub fn check_given(&self, value: ParameterValue) -> Result<(), String> {
        self.check(&value.meant_as(&self.example))
    }

    /// Checks type and range of a value.
    fn check(&self, value: &ParameterValue) -> Result<(), String> {
        if *value == ParameterValue::NotSet {
            return if self.is_optional() { Ok(()) } else { Err("cannot be removed".into()) };
        }
        if value.type_id() != self.example.type_id() {
            let allowed = self.allowed().map_or_else(String::new, |allowed| format!(" ({allowed})"));
            let (wanted, given) = (self.example.type_name(), value.type_name());
            return Err(format!("has the type {wanted}{allowed}; it cannot be the {given} {value}"));
        }
        match (value, self.range) {
            (ParameterValue::Double(value), None) => check_finite(*value),
            (ParameterValue::DoubleArray(values), None) => values.iter().try_for_each(|value| check_finite(*value)),
            (ParameterValue::String(value), _) if !self.choices.is_empty() && !self.choices.contains(value) => {
                Err(format!("is '{value}'; it must be one of {}", self.choices.join(", ")))
            }
            (_, None) => Ok(()),
            (ParameterValue::Double(value), Some(range)) => check_double(*value, range),
            (ParameterValue::DoubleArray(values), Some(range)) => {
                values.iter().try_for_each(|value| check_double(*value, range))
            }
            (ParameterValue::Integer(value), Some(range)) => check_integer(*value, range),
            (ParameterValue::IntegerArray(values), Some(range)) => {
                values.iter().try_for_each(|value| check_integer(*value, range))
            }
            (_, Some(_)) => Ok(()),
        }
    }
}

impl Parameter {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the type.
    pub fn type_name(&self) -> &'static str {
        self.example.type_name()
    }

    /// Value at the start unless the user sets another; not set for an optional parameter.
    pub fn default_value(&self) -> &ParameterValue {
        &self.default
    }

    /// Description, with the unit.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Rule that a range cannot express; empty: none.
    pub fn constraint_text(&self) -> &str {
        &self.constraints
    }

    /// Returns true if the parameter cannot change after the start.
    pub fn is_read_only(&self) -> bool {
        self.read_only
    }

    /// Range or choices in words.
    pub fn allowed(&self) -> Option<String> {
        match self.range {
            Some(ParameterRange::Double { from, to, .. }) => Some(format!("{from} to {to}")),
            Some(ParameterRange::Integer { from, to, .. }) => Some(format!("{from} to {to}")),
            None if !self.choices.is_empty() => Some(self.choices.join(", ")),
            None => None,
        }
    }
}

fn check_finite(value: f64) -> Result<(), String> {
    if value.is_finite() { Ok(()) } else { Err(format!("is {value}; it must be a finite number")) }
}

fn check_double(value: f64, range: ParameterRange) -> Result<(), String> {
    let ParameterRange::Double { from, to, step } = range else { return Ok(()) };
    // A NaN is in no range.
    if !(from..=to).contains(&value) {
        return Err(format!("{value} is outside {from} to {to}"));
    }
    if step > 0.0 {
        let steps = (value - from) / step;
        // rclcpp compares within a few units in the last place; the ends of the range are always allowed.
        let off = (steps - steps.round()).abs() > 1e-9 * steps.abs().max(1.0);
        if off && value < to {
            return Err(format!("{value} is not {from} plus a multiple of {step}"));
        }
    }
    Ok(())
}

fn check_integer(value: i64, range: ParameterRange) -> Result<(), String> {
    let ParameterRange::Integer { from, to, step } = range else { return Ok(()) };
    if !(from..=to).contains(&value) {
        return Err(format!("{value} is outside {from} to {to}"));
    }
    if step > 0 && value != to && !value.abs_diff(from).is_multiple_of(step) {
        return Err(format!("{value} is not {from} plus a multiple of {step}"));
    }
    Ok(())
}

/// Changes that belong together: names and new values.
pub type ParameterChanges = [(String, ParameterValue)];

type Validator = Box<dyn Fn(&Parameters, &ParameterChanges) -> Result<(), String> + Send>;
type ChangeFollower = Box<dyn Fn(&ParameterChanges) + Send>;
type Publication = Box<dyn Fn(&ParameterChanges) + Send + Sync>;

struct ParameterEntry {
    declaration: Parameter,
    value: ParameterValue,
}

#[derive(Default)]
struct Hooks {
    validators: Vec<Validator>,
    followers: Vec<ChangeFollower>,
}

struct Inner {
    entries: Mutex<BTreeMap<String, ParameterEntry>>,
    /// Also orders changes: validators, store and followers see one change after the other.
    hooks: Mutex<Hooks>,
    publication: OnceLock<Publication>,
}

/// A node's parameters. Clones are the same store.
#[derive(Clone)]
pub struct Parameters {
    inner: Arc<Inner>,
}

impl fmt::Debug for Parameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Parameters").field("names", &self.names()).finish()
    }
}

impl Parameters {
    /// Declares a node's parameters and those every node has, with the overrides of the command line.
    pub(super) fn declare(mut declarations: Vec<Parameter>, overrides: &[NodeOverride]) -> Result<Self, RosError> {
        declarations.push(Parameter::bool(USE_SIM_TIME, false).describe("uses the time of /clock"));
        declarations.push(
            Parameter::bool(START_TYPE_DESCRIPTION_SERVICE, true).describe("offers ~/get_type_description").read_only(),
        );
        declarations.extend(introspection::parameters());
        let mut entries = BTreeMap::new();
        for declaration in declarations {
            let refuse = |reason: String| RosError::Parameter { name: declaration.name.clone(), reason };
            let given = overrides.iter().rev().find(|o| o.name == declaration.name);
            let value =
                given.map_or_else(|| declaration.default.clone(), |o| o.value.clone().meant_as(&declaration.example));
            declaration.check(&value).map_err(refuse)?;
            let name = declaration.name.clone();
            if entries.insert(name.clone(), ParameterEntry { declaration, value }).is_some() {
                return Err(RosError::Parameter { name, reason: "is declared twice".into() });
            }
        }
        let entries = Mutex::new(entries);
        Ok(Parameters { inner: Arc::new(Inner { entries, hooks: Mutex::default(), publication: OnceLock::new() }) })
    }

    /// Calls `publication` after every change and its followers.
    pub(super) fn publish_changes(&self, publication: impl Fn(&ParameterChanges) + Send + Sync + 'static) {
        let _the_first_stays = self.inner.publication.set(Box::new(publication));
    }

    fn entries(&self) -> MutexGuard<'_, BTreeMap<String, ParameterEntry>> {
        self.inner.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Names of the parameters that have a value, sorted. A dump of them can be loaded.
    pub(super) fn names_with_values(&self) -> Vec<String> {
        let entries = self.entries();
        let with_value = entries.iter().filter(|(_, entry)| entry.value != ParameterValue::NotSet);
        with_value.map(|(name, _)| name.clone()).collect()
    }

    /// Names of all parameters, sorted.
    pub fn names(&self) -> Vec<String> {
        self.entries().keys().cloned().collect()
    }

    /// Value of a parameter, if it is declared.
    pub fn get(&self, name: &str) -> Option<ParameterValue> {
        self.entries().get(name).map(|entry| entry.value.clone())
    }

    /// Declaration of a parameter.
    pub fn declaration(&self, name: &str) -> Option<Parameter> {
        self.entries().get(name).map(|entry| entry.declaration.clone())
    }

    /// All parameters with their values, sorted by name.
    pub fn all(&self) -> Vec<(String, ParameterValue)> {
        self.entries().iter().map(|(name, entry)| (name.clone(), entry.value.clone())).collect()
    }

    fn typed<T>(&self, name: &str, pick: impl FnOnce(ParameterValue) -> Option<T>) -> T {
        let value = self.get(name).and_then(pick);
        value.unwrap_or_else(|| panic!("parameter '{name}' is not declared with the type it is read as"))
    }

    /// Value of a declared bool.
    ///
    /// # Panics
    /// The node does not declare such a parameter: a mistake in the program, which no input can cause. So with the other typed
    /// getters.
    pub fn bool(&self, name: &str) -> bool {
        self.typed(name, |value| if let ParameterValue::Bool(v) = value { Some(v) } else { None })
    }

    /// Value of a declared integer; see [`Parameters::bool`].
    pub fn integer(&self, name: &str) -> i64 {
        self.typed(name, |value| if let ParameterValue::Integer(v) = value { Some(v) } else { None })
    }

    /// Value of a declared double; see [`Parameters::bool`].
    pub fn double(&self, name: &str) -> f64 {
        self.typed(name, |value| if let ParameterValue::Double(v) = value { Some(v) } else { None })
    }

    /// Value of a declared string; see [`Parameters::bool`].
    pub fn string(&self, name: &str) -> String {
        self.typed(name, |value| if let ParameterValue::String(v) = value { Some(v) } else { None })
    }

    /// Value of a declared array of strings; see [`Parameters::bool`].
    pub fn string_array(&self, name: &str) -> Vec<String> {
        self.typed(name, |value| if let ParameterValue::StringArray(v) = value { Some(v) } else { None })
    }

    /// Value of a declared array of integers; see [`Parameters::bool`].
    pub fn integer_array(&self, name: &str) -> Vec<i64> {
        self.typed(name, |value| if let ParameterValue::IntegerArray(v) = value { Some(v) } else { None })
    }

    /// Value of a declared array of doubles; see [`Parameters::bool`].
    pub fn double_array(&self, name: &str) -> Vec<f64> {
        self.typed(name, |value| if let ParameterValue::DoubleArray(v) = value { Some(v) } else { None })
    }

    /// Calls `validator` before every change; `Err` rejects the change with that reason. It must not change parameters.
    pub fn on_set(&self, validator: impl Fn(&ParameterChanges) -> Result<(), String> + Send + 'static) {
        self.on_set_together(move |_, changes| validator(changes));
    }

    /// Adds a validator that depends on the values of other parameters, see [`Parameters::on_set`].
    pub fn on_set_together(
        &self,
        validator: impl Fn(&Parameters, &ParameterChanges) -> Result<(), String> + Send + 'static,
    ) {
        self.hooks().validators.push(Box::new(validator));
    }

    /// Calls `follower` after every change. It must not change parameters.
    pub fn on_change(&self, follower: impl Fn(&ParameterChanges) + Send + 'static) {
        self.hooks().followers.push(Box::new(follower));
    }

    fn hooks(&self) -> MutexGuard<'_, Hooks> {
        self.inner.hooks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes one parameter from inside the node, by the rules of the services.
    ///
    /// # Errors
    /// The change is rejected, with the reason.
    pub fn set(&self, name: &str, value: ParameterValue) -> Result<(), RosError> {
        self.set_all(vec![(name.to_string(), value)])
            .map_err(|reason| RosError::Parameter { name: name.to_string(), reason })
    }

    /// Changes all parameters or none, and publishes one event.
    pub(super) fn set_all(&self, changes: Vec<(String, ParameterValue)>) -> Result<(), String> {
        let hooks = self.hooks();
        {
            let entries = self.entries();
            for (name, value) in &changes {
                let entry = entries.get(name).ok_or_else(|| undeclared(name, entries.keys()))?;
                // A dump holds read-only parameters too, and loads where they are the same.
                if entry.declaration.read_only && entry.value != *value {
                    return Err(format!(
                        "parameter '{name}' is {} and read-only; set it at the start, with -p or --params-file",
                        entry.value
                    ));
                }
                entry.declaration.check(value).map_err(|reason| format!("parameter '{name}' {reason}"))?;
            }
        }
        hooks.validators.iter().try_for_each(|validator| validator(self, &changes))?;
        {
            let mut entries = self.entries();
            for (name, value) in &changes {
                if let Some(entry) = entries.get_mut(name) {
                    entry.value = value.clone();
                }
            }
        }
        for follower in &hooks.followers {
            follower(&changes);
        }
        drop(hooks);
        if let Some(publish) = self.inner.publication.get() {
            publish(&changes);
        }
        Ok(())
    }
}

/// Longest name that is compared with others (bytes): the time for a comparison grows with the square.
const MAX_COMPARED: usize = 200;

/// Refuses a name, with the nearest that exists.
fn undeclared<'a>(name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let known = known.filter(|_| name.len() <= MAX_COMPARED);
    let nearest = known.map(|known| (strsim::levenshtein(name, known), known)).min();
    match nearest.filter(|(distance, _)| *distance <= 1 + name.len() / 4) {
        Some((_, nearest)) => format!("parameter '{name}' is not declared; did you mean '{nearest}'?"),
        None => format!("parameter '{name}' is not declared"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_name_the_value_and_what_is_allowed() {
        let law = Parameter::optional("law", ParameterValue::String(String::new())).choices(&["constant", "optimal"]);
        assert_eq!(law.check(&ParameterValue::String("optimal".into())), Ok(()));
        let refused = law.check(&ParameterValue::String("foo".into()));
        assert_eq!(refused, Err("is 'foo'; it must be one of constant, optimal".into()));
        let speed = Parameter::double("speed", 1.0).range(0.5, 10.0);
        let refused = speed.check(&ParameterValue::String("None".into()));
        assert_eq!(refused, Err("has the type double (0.5 to 10); it cannot be the string 'None'".into()));
        assert!(Parameter::double("any", 1.0).check(&ParameterValue::Double(f64::NAN)).is_err());
        let known = ["work_speed_rpm".to_string(), "x".to_string()];
        let text = undeclared("work_sped_rpm", known.iter());
        assert_eq!(text, "parameter 'work_sped_rpm' is not declared; did you mean 'work_speed_rpm'?");
        assert_eq!(undeclared("other", known.iter()), "parameter 'other' is not declared");
        let long = "x".repeat(MAX_COMPARED + 1);
        assert_eq!(undeclared(&long, [long.clone() + "y"].iter()), format!("parameter '{long}' is not declared"));
    }

    #[test]
    fn ranges_include_their_ends_and_know_steps() {
        let double = Parameter::double("d", 1.0).range_with_step(0.0, 1.05, 0.1);
        for good in [0.0, 0.1, 0.3, 0.7000000000000001, 1.05] {
            assert_eq!(double.check(&ParameterValue::Double(good)), Ok(()), "{good}");
        }
        for bad in [-0.1, 0.15, 1.06, f64::NAN, f64::INFINITY] {
            assert!(double.check(&ParameterValue::Double(bad)).is_err(), "{bad}");
        }
        let integer = Parameter::integer("i", 0).integer_range_with_step(-4, 5, 3);
        for good in [-4, -1, 2, 5] {
            assert_eq!(integer.check(&ParameterValue::Integer(good)), Ok(()), "{good}");
        }
        for bad in [-5, 0, 4, 6] {
            assert!(integer.check(&ParameterValue::Integer(bad)).is_err(), "{bad}");
        }
        let array = Parameter::double_array("a", &[]).range(0.0, 1.0);
        assert!(array.check(&ParameterValue::DoubleArray(vec![0.5, 2.0])).is_err());
    }

    #[test]
    fn an_optional_parameter_has_a_type_and_may_be_without_a_value() {
        let optional = Parameter::optional("o", ParameterValue::Double(0.0)).range(0.0, 10.0);
        assert_eq!(optional.default, ParameterValue::NotSet);
        assert_eq!(optional.check(&ParameterValue::NotSet), Ok(()));
        assert_eq!(optional.check(&ParameterValue::Double(5.0)), Ok(()));
        assert!(optional.check(&ParameterValue::Double(11.0)).is_err());
        assert!(optional.check(&ParameterValue::Bool(true)).is_err());
        let always = Parameter::double("d", 1.0);
        assert_eq!(always.check(&ParameterValue::NotSet), Err("cannot be removed".into()));
    }

    #[test]
    fn types_do_not_mix_but_a_file_may_leave_out_the_point() {
        let double = Parameter::double("d", 1.0);
        assert!(double.check(&ParameterValue::Integer(1)).is_err());
        let meant = ParameterValue::Integer(1).meant_as(&double.default);
        assert_eq!(meant, ParameterValue::Double(1.0));
        let empty = ParameterValue::StringArray(vec![]).meant_as(&ParameterValue::DoubleArray(vec![1.0]));
        assert_eq!(empty, ParameterValue::DoubleArray(vec![]));
        let text = ParameterValue::String("1".into()).meant_as(&double.default);
        assert!(double.check(&text).is_err(), "a text is not a number");
    }
}
