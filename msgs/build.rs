// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Generates the Rust types from the interface files.

mod generator;

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    for watched in ["build.rs", "generator", "src/syntax.rs", "msg", "srv", "action", "standard"] {
        println!("cargo::rerun-if-changed={watched}");
    }
    let text = generator::generate(&root)?;
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("interfaces.rs"), text)?;
    Ok(())
}
