// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Definitions of foreign types: from the message packages that are installed here, or from the node that publishes them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use camwright_msgs::type_description_interfaces::srv::{
    GetTypeDescription, GetTypeDescriptionRequest, GetTypeDescriptionResponse,
};

use camwright_bag::definition;
use camwright_ros::{Client, Node, TopicInfo};

/// A type's definition with those of all it uses, in the bag's form (`ros2msg`), and its hash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct DefinitionText {
    pub(super) text: String,
    /// Type hash; empty if no publisher announces it.
    pub(super) hash: String,
}

/// State of a type's definition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum DefinitionState {
    Yes(DefinitionText),
    /// Its publisher has been asked, or will be once it can be.
    NotYet,
    No(String),
}

/// A publisher's node that is asked.
struct Question {
    node: String,
    hash: String,
    client: Client<GetTypeDescription>,
    is_sent: bool,
}

/// All types that were asked for so far.
#[derive(Default)]
pub(super) struct Definitions {
    known: BTreeMap<String, Result<DefinitionText, String>>,
    questions: BTreeMap<String, Question>,
}

impl Definitions {
    /// Finds the definition of the type of `found`. If a node had to be queried, the executor thread calls `answered` with the type and
    /// the answer; [`Definitions::learn`] takes that.
    pub(super) fn find(
        &mut self,
        node: &Node,
        found: &TopicInfo,
        answered: impl FnOnce(String, GetTypeDescriptionResponse) + Send + 'static,
    ) -> DefinitionState {
        let type_name = found.type_name.as_str();
        if let Some(info) = camwright_msgs::by_type_name(type_name).filter(|info| !info.schema.is_empty()) {
            return DefinitionState::Yes(DefinitionText { text: info.schema.into(), hash: info.type_hash.into() });
        }
        if !self.known.contains_key(type_name)
            && let Some(installed) = installed(type_name, found)
        {
            self.known.insert(type_name.to_owned(), installed);
        }
        match self.known.get(type_name) {
            Some(Ok(definition)) => DefinitionState::Yes(definition.clone()),
            Some(Err(reason)) => DefinitionState::No(reason.clone()),
            None => self.ask(node, found, answered),
        }
    }

    /// Queries the node of a publisher that announces its type's hash, once it is reachable.
    fn ask(
        &mut self,
        node: &Node,
        found: &TopicInfo,
        answered: impl FnOnce(String, GetTypeDescriptionResponse) + Send + 'static,
    ) -> DefinitionState {
        let type_name = found.type_name.clone();
        self.questions.retain(|asked, question| {
            *asked != type_name || found.publishers.iter().any(|p| p.node.as_deref() == Some(question.node.as_str()))
        });
        if !self.questions.contains_key(&type_name) {
            let published = found.publishers.iter().find_map(|p| Some((p.type_hash.clone()?, p.node.clone())));
            let (hash, publisher) = match published {
                // The name of a node comes after its endpoints.
                Some((_, None)) => return DefinitionState::NotYet,
                Some((hash, Some(publisher))) => (hash, publisher),
                None => {
                    let where_else = "no installed package has it, and its publishers do not publish its hash";
                    return DefinitionState::No(format!(
                        "the definition of {type_name} is not known here: {where_else}"
                    ));
                }
            };
            match node.client::<GetTypeDescription>(&format!("{publisher}/get_type_description")) {
                Ok(client) => {
                    let question = Question { node: publisher, hash, client, is_sent: false };
                    self.questions.insert(type_name.clone(), question);
                }
                Err(error) => return DefinitionState::No(error.to_string()),
            }
        }
        let Some(question) = self.questions.get_mut(&type_name) else { return DefinitionState::NotYet };
        if !question.is_sent && question.client.is_ready() {
            let request = GetTypeDescriptionRequest {
                type_name: type_name.clone(),
                type_hash: question.hash.clone(),
                include_type_sources: true,
            };
            match question.client.call_with(&request, move |response| answered(type_name, response)) {
                Ok(_) => question.is_sent = true,
                Err(error) => return DefinitionState::No(error.to_string()),
            }
        }
        DefinitionState::NotYet
    }

    /// Takes the answer of a node that was asked.
    pub(super) fn learn(&mut self, type_name: &str, response: &GetTypeDescriptionResponse) {
        let Some(question) = self.questions.remove(type_name) else { return };
        let definition = if response.successful {
            let sources: BTreeMap<&str, &str> = response
                .type_sources
                .iter()
                .filter(|source| source.encoding == "msg")
                .map(|source| (source.type_name.as_str(), source.raw_file_contents.as_str()))
                .collect();
            text(type_name, |wanted| sources.get(wanted).map(|&text| text.to_owned()))
        } else {
            Err(response.failure_reason.clone())
        };
        let definition = definition
            .map(|text| DefinitionText { text, hash: question.hash })
            .map_err(|reason| format!("{} does not send the definition of {type_name}: {reason}", question.node));
        self.known.insert(type_name.to_owned(), definition);
    }
}

/// The definition of a type whose package is installed, where `AMENT_PREFIX_PATH` says.
fn installed(type_name: &str, found: &TopicInfo) -> Option<Result<DefinitionText, String>> {
    let prefixes = std::env::var_os("AMENT_PREFIX_PATH")?;
    let prefixes: Vec<PathBuf> = std::env::split_paths(&prefixes).collect();
    from_packages(&prefixes, type_name).map(|definition| {
        // The hash announced by the publishers identifies the sent type; the installed one may be another version.
        let published = found.publishers.iter().find_map(|p| p.type_hash.clone());
        let (text, hash) = definition?;
        match published {
            Some(published) if !hash.is_empty() && hash != published => {
                Err(format!("{type_name} is installed as {hash}, and published as {published}"))
            }
            published => Ok(DefinitionText { text, hash: published.unwrap_or(hash) }),
        }
    })
}

/// Text and hash of a type from the package that has it; the hash stands in the file of the type's description beside it.
fn from_packages(prefixes: &[PathBuf], type_name: &str) -> Option<Result<(String, String), String>> {
    let read = |name: &str, extension: &str| {
        let (package, rest) = name.split_once('/')?;
        let file = format!("{rest}.{extension}");
        prefixes.iter().find_map(|p| std::fs::read_to_string(p.join("share").join(package).join(&file)).ok())
    };
    if !is_message(type_name) {
        return None;
    }
    read(type_name, "msg")?;
    let hash = read(type_name, "json").and_then(|text| {
        let description: serde_json::Value = serde_json::from_str(&text).ok()?;
        let mut hashes = description["type_hashes"].as_array()?.iter();
        let own = hashes.find(|entry| entry["type_name"] == type_name)?;
        own["hash_string"].as_str().map(str::to_owned)
    });
    Some(text(type_name, |wanted| read(wanted, "msg")).map(|text| (text, hash.unwrap_or_default())))
}

/// Returns whether it has the form `package/msg/Type`, so that it names a file and nothing above it.
fn is_message(type_name: &str) -> bool {
    let is_word = |word: &str| !word.is_empty() && word.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
    matches!(type_name.split('/').collect::<Vec<_>>()[..], [package, "msg", name] if is_word(package) && is_word(name))
}

/// The definition of a type, verbatim, followed by those of the types it uses: depth first, in the order of their names, each once, as
/// rosbag2 writes them.
fn text(type_name: &str, find: impl Fn(&str) -> Option<String>) -> Result<String, String> {
    let mut text = String::new();
    // Types that still have to be written, the next one last.
    let mut waiting = vec![type_name.to_owned()];
    let mut written = BTreeSet::new();
    while let Some(next) = waiting.pop() {
        if !written.insert(next.clone()) {
            continue;
        }
        let definition = find(&next).ok_or_else(|| format!("{next}, which {type_name} uses, is not known"))?;
        if !text.is_empty() {
            text.push_str(&format!("\n{}\nMSG: {}\n", "=".repeat(80), next.replace("/msg/", "/")));
        }
        let package = next.split('/').next().unwrap_or_default();
        waiting.extend(used_by(package, &definition).into_iter().rev());
        text.push_str(&definition);
    }
    Ok(text)
}

/// Full names of the types that the fields of a definition have, in order.
fn used_by(package: &str, definition: &str) -> BTreeSet<String> {
    let full = |name: String| name.replacen('/', "/msg/", 1);
    definition::used_by(package, definition).into_iter().map(full).filter(|name| is_message(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Our generated texts, which rosbag2's own rule made, are the judge.
    #[test]
    fn a_text_is_put_together_as_that_of_the_types_we_know() {
        let source = |wanted: &str| camwright_msgs::by_type_name(wanted).map(|info| info.source.to_owned());
        let mut compared = 0;
        for info in camwright_msgs::ALL.iter().filter(|info| info.source_encoding == "msg") {
            assert_eq!(text(info.type_name, source).as_deref(), Ok(info.schema), "{}", info.type_name);
            compared += 1;
        }
        assert!(compared > 100, "{compared} types were compared");
    }

    #[test]
    fn used_types_follow_from_the_fields() {
        let text = "# Foo comment\nHeader header\nPoint[<=3] points # Bar\nstring<=32 name\ngeometry_msgs/Pose pose\n\
                    uint8 A=1\nother/msg/Thing[2] things\nstring[<=2] s 'x'\n../../etc/passwd x\n";
        let used: Vec<String> = used_by("mine", text).into_iter().collect();
        assert_eq!(used, ["geometry_msgs/msg/Pose", "mine/msg/Point", "other/msg/Thing", "std_msgs/msg/Header"]);
        assert!(!is_message("a/msg/../b") && !is_message("a/srv/B") && is_message("a_b/msg/C2"));
    }

    #[test]
    fn a_type_that_uses_itself_or_an_unknown_one_ends() {
        let find = |wanted: &str| (wanted == "a/msg/Loop").then(|| "Loop[] next\n".to_owned());
        assert_eq!(text("a/msg/Loop", find).as_deref(), Ok("Loop[] next\n"));
        let find = |wanted: &str| (wanted == "a/msg/A").then(|| "B b\n".to_owned());
        assert_eq!(text("a/msg/A", find), Err("a/msg/B, which a/msg/A uses, is not known".into()));
    }
}
