// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright schema`: a JSON Schema validator of another project accepts every shipped file and refuses a misspelt key, and the reference
//! documents are what the schema says.

use crate::support::{Domain, Folder, PeerEnv, peer_env, repository};
use camwright_files::file_kind::FileKind;
use camwright_files::locate::{list, locate};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Set it to write the reference documents anew.
const WRITE: &str = "CAMWRIGHT_WRITE_REFERENCE";

fn camwright(words: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_camwright")).args(words).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Errors of each file by the validator.
fn judged(environment: &PeerEnv, schema: &Path, files: &[PathBuf]) -> BTreeMap<String, Vec<String>> {
    let domain = Domain::reserve();
    let mut command = environment.python("judge_schema.py", &domain);
    let output = command.arg(schema).args(files).output().expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Text of every shipped file of a kind, by its name.
fn shipped(kind: FileKind) -> Vec<(String, String)> {
    let folder = match kind {
        FileKind::Machine => "machines",
        FileKind::Study => "studies",
        FileKind::Job | FileKind::TurningJob | FileKind::MillingJob => "jobs",
    };
    let texts = list(folder).into_iter().map(|name| {
        let text = locate(folder, &name, "yaml", None).expect("a shipped file").text;
        (name, text)
    });
    texts.filter(|(_, text)| text.contains(&format!("schema: camwright/{}/1", kind.name()))).collect()
}

#[test]
fn a_validator_accepts_shipped_files_and_refuses_a_misspelt_key() {
    let Some(environment) = peer_env() else { return };
    let folder = Folder::new("schema");
    let mut count = 0;
    for kind in FileKind::ALL {
        let schema = folder.path().join(format!("{}.schema.json", kind.name()));
        std::fs::write(&schema, camwright(&["schema", kind.name()])).expect("it can be written");
        let (mut good, mut bad) = (Vec::new(), Vec::new());
        for (name, text) in shipped(kind) {
            let (path, misspelt) = (folder.path().join(&name), folder.path().join(format!("{name}.misspelt")));
            std::fs::write(&path, &text).expect("it can be written");
            std::fs::write(&misspelt, text.replacen("\nname:", "\nnmae:", 1)).expect("it can be written");
            good.push(path);
            bad.push(misspelt);
        }
        count += good.len();
        for (file, errors) in judged(environment, &schema, &good) {
            assert!(errors.is_empty(), "{file}: {errors:?}");
        }
        for (file, errors) in judged(environment, &schema, &bad) {
            let text = errors.join("\n");
            assert!(text.contains("nmae") && text.contains("'name' is a required property"), "{file}: {text}");
        }
    }
    assert!(count > 14, "{count}");
}

#[test]
fn the_reference_documents_are_what_the_schema_says() {
    for kind in FileKind::ALL {
        let path = repository().join(format!("docs/reference/{}.md", kind.name()));
        let text = format!(
            "# Keys of `camwright/{0}/1` files\n\nMade by `camwright schema {0} --table`. `[]` stands for the elements of a list.\n\n{1}",
            kind.name(),
            camwright(&["schema", kind.name(), "--table"])
        );
        if std::env::var_os(WRITE).is_some() {
            std::fs::write(&path, &text).expect("it can be written");
        }
        let written = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            written == text,
            "{} is out of date; write it with {WRITE}=1 cargo test -p camwright_nodes --test planning reference_documents",
            path.display()
        );
    }
}
