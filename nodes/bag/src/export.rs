//! What other programs want of a bag: tables, one of each topic, or a copy in another layout, a smaller one (Zstandard).

use std::fs;
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

pub use super::tables::{TableFormat, to_tables};
use super::writer::REPEATED;
use super::{Bag, BagError, BagWriter, Preset, WriterOptions};
use crate::progress;

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Exported {
    /// Files of tables, or the new bag.
    pub paths: Vec<PathBuf>,
    pub messages: u64,
    /// Topics that could not be written as tables, and why.
    pub left_out: Vec<(String, String)>,
}

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
    let mut told = bag.custom_data().clone();
    // The copy is one file.
    told.remove(REPEATED);
    let outcome = copied.and_then(|count| writer.close_as_it_was(told).map(|_| count));
    match outcome {
        Ok(messages) => Ok(Exported { paths: vec![into.to_owned()], messages, left_out: Vec::new() }),
        Err(error) => {
            // Ours, made a moment ago, and not whole.
            drop(fs::remove_dir_all(into));
            Err(error)
        }
    }
}

/// A bar over the messages of a bag, which is read so many times.
pub(super) fn bar_over(bag: &Bag, times: u64) -> ProgressBar {
    let messages = bag.message_counts().iter().fold(0, |sum: u64, count| sum.saturating_add(*count));
    progress::bar(messages.saturating_mul(times), "{bar:40} {human_pos} of {human_len} messages (eta {eta})")
}
