// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages mean the same to us and to real ROS 2 on the wire: every type we know, both ways, against rclpy and Fast CDR.

use crate::support;

use byteorder::LittleEndian;
use camwright_msgs::Message;
use serde_json::{Value, json};
use std::io::Write;
use support::{Domain, Guarded, PATIENCE, peer_env};

/// Messages made up for each type, in addition to the new one: enough to meet empty, single and longer sequences in all nestings.
const SEEDS: u64 = 8;
/// Plain CDR, little endian, no options: how every ROS 2 sample begins.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

type Check = fn(&[u8], &Value) -> Result<Vec<u8>, String>;

/// Reads rclpy's bytes as ours, compares the values, and writes ours as bytes again.
fn through_rust<M: Message>(theirs: &[u8], plain: &Value) -> Result<Vec<u8>, String> {
    let (header, payload) = theirs.split_at(ENCAPSULATION.len());
    if header[..2] != ENCAPSULATION[..2] {
        return Err(format!("not plain little-endian CDR: {header:?}"));
    }
    let (ours, _) = cdr_encoding::from_bytes::<M, LittleEndian>(payload).map_err(|error| error.to_string())?;
    let mut values = serde_json::to_value(&ours).map_err(|error| error.to_string())?;
    without_padding_members(&mut values);
    if &values != plain {
        return Err(format!("we read {values}"));
    }
    let mut bytes = header.to_vec();
    bytes.extend(cdr_encoding::to_vec::<M, LittleEndian>(&ours).map_err(|error| error.to_string())?);
    Ok(bytes)
}

/// rosidl gives a type without fields one byte that its Python classes do not show.
fn without_padding_members(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.remove("structure_needs_at_least_one_member");
            fields.values_mut().for_each(without_padding_members);
        }
        Value::Array(items) => items.iter_mut().for_each(without_padding_members),
        _ => {}
    }
}

macro_rules! checks {
    ($($message:ty,)*) => { &[$((<$message as Message>::TYPE_NAME, through_rust::<$message> as Check)),*] };
}

const CHECKS: &[(&str, Check)] = camwright_msgs::for_each_message!(checks);

struct Rclpy {
    process: Guarded,
    stdin: std::process::ChildStdin,
}

impl Rclpy {
    fn ask(&mut self, question: &Value) -> Value {
        writeln!(self.stdin, "{question}").expect("rclpy listens");
        let line = self
            .process
            .line(PATIENCE)
            .unwrap_or_else(|| panic!("asked {question}: rclpy ended{}", self.process.complaint()));
        serde_json::from_str(&line).expect("rclpy answers in JSON")
    }
}

#[test]
fn every_message_means_the_same_to_rclpy_and_to_us_both_ways() {
    let Some(env) = peer_env() else { return };
    let mut process = Guarded::start("wire.py", &mut env.python("wire.py", &Domain::reserve()));
    let stdin = process.take_stdin();
    let mut rclpy = Rclpy { process, stdin };
    let mut wrong = Vec::new();
    for (name, check) in CHECKS {
        for seed in 0..=SEEDS {
            let theirs = rclpy.ask(&json!({ "type": name, "seed": seed }));
            let bytes = from_hex(theirs["cdr"].as_str().expect("hexadecimal bytes"));
            match check(&bytes, &theirs["plain"]) {
                Err(what) => wrong.push(format!("{name}, seed {seed}: {what}; rclpy wrote {}", theirs["plain"])),
                Ok(ours) => {
                    let back = rclpy.ask(&json!({ "type": name, "cdr": to_hex(&ours) }));
                    if back["plain"] != theirs["plain"] {
                        wrong.push(format!(
                            "{name}, seed {seed}: rclpy reads {} in what we wrote of {}",
                            back["plain"], theirs["plain"]
                        ));
                    }
                    // Bytes cannot be compared: rclpy leaves whatever it finds in the gaps, and estimates the size beforehand.
                    if ours.len() > bytes.len() {
                        wrong.push(format!(
                            "{name}, seed {seed}: we write {} bytes, rclpy {}",
                            ours.len(),
                            bytes.len()
                        ));
                    }
                }
            }
        }
    }
    let first: Vec<_> = wrong.iter().take(10).map(|what| what.chars().take(400).collect::<String>()).collect();
    assert!(
        wrong.is_empty(),
        "{} messages differ; first:
{}",
        wrong.len(),
        first.join(
            "
"
        )
    );
}

#[test]
fn every_message_type_of_the_registry_is_tried() {
    use camwright_msgs::InterfaceKind;
    let events = |name: &str| name.ends_with("_Event");
    let known =
        camwright_msgs::ALL.iter().filter(|info| info.kind == InterfaceKind::Message && !events(info.type_name));
    assert_eq!(
        CHECKS.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        known.map(|info| info.type_name).collect::<Vec<_>>()
    );
}

fn to_hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn from_hex(text: &str) -> Vec<u8> {
    (0..text.len()).step_by(2).map(|at| u8::from_str_radix(&text[at..at + 2], 16).expect("hexadecimal")).collect()
}
