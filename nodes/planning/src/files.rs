// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files written by `camwright plan`, each announced before it is written.

use crate::drawing::{Plot, png, svg};
use camwright_files::{ConfigError, FileLocation};
use serde::Serialize;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes files and announces each.
pub(super) struct Files<F> {
    progress: F,
}

impl<F: FnMut(&Path)> Files<F> {
    pub(super) fn new(progress: F) -> Self {
        Self { progress }
    }

    /// Writes one, with the folders above it.
    pub(super) fn write(
        &mut self,
        path: &Path,
        write: &dyn Fn(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), ConfigError> {
        (self.progress)(path);
        let attempt = || -> io::Result<()> {
            if let Some(folder) = path.parent() {
                fs::create_dir_all(folder)?;
            }
            let mut to = BufWriter::new(File::create(path)?);
            write(&mut to)?;
            to.flush()
        };
        attempt().map_err(|error| ConfigError::at(FileLocation::file(path), format!("cannot be written: {error}")))
    }

    /// A drawing, as SVG and as PNG.
    pub(super) fn plot(&mut self, folder: &Path, plot: &Plot) -> Result<(), ConfigError> {
        let path = |extension: &str| folder.join(format!("{}.{extension}", plot.name));
        self.write(&path("svg"), &|to| to.write_all(svg(&plot.drawing).as_bytes()))?;
        self.write(&path("png"), &|to| to.write_all(&png(&plot.drawing)?))
    }

    /// Drawings, each as SVG and as PNG.
    pub(super) fn plots(&mut self, folder: &Path, plots: &[Plot]) -> Result<(), ConfigError> {
        plots.iter().try_for_each(|plot| self.plot(folder, plot))
    }

    /// Something as JSON for people.
    pub(super) fn json(&mut self, path: &Path, what: &impl Serialize) -> Result<(), ConfigError> {
        self.write(path, &|to| {
            serde_json::to_writer_pretty(&mut *to, what)?;
            writeln!(to)
        })
    }
}
