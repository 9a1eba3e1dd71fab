// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Exports of a bag: a table of each topic, or a copy in another layout, compressed for example.

use std::fs;
use std::path::Path;

pub use super::exported::Exported;
pub use super::tables::{TableFormat, to_tables};
use super::writer::REPEATED;
use super::{Bag, BagError, BagWriter, Preset, WriterOptions};
use crate::progress::bar_over;

/// A copy of `bag` in another layout, compressed for example: the same messages with the same times and numbers, in one file.
///
/// # Errors
/// The bag cannot be read, or the new one exists already or cannot be written; then none is left.
pub fn to_bag(bag: &Bag, into: &Path, preset: Preset) -> Result<Exported, BagError> {
    let mut writer = BagWriter::create(into, &WriterOptions { preset, ..WriterOptions::default() })?;
    let progress = bar_over(bag, 1);
    let mut copy = || {
        let ids: Vec<_> = bag.topics().iter().map(|topic| writer.add_topic(topic)).collect::<Result<_, _>>()?;
        let mut messages = bag.messages();
        let mut count = 0;
        while let Some(message) = messages.next_message()? {
            writer.copy(ids[message.topic], &message)?;
            count += 1;
            progress.inc(1);
        }
        Ok(count)
    };
    let copied = copy();
    progress.finish_and_clear();
    let mut custom_data = bag.custom_data().clone();
    // The copy is one file.
    custom_data.remove(REPEATED);
    let outcome = copied.and_then(|count| writer.close_as_it_was(custom_data).map(|_| count));
    match outcome {
        Ok(messages) => Ok(Exported { paths: vec![into.to_owned()], messages, left_out: Vec::new() }),
        Err(error) => {
            // Ours, made a moment ago, and not whole.
            drop(fs::remove_dir_all(into));
            Err(error)
        }
    }
}
