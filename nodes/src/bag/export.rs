//! What other programs want of a bag: tables (CSV), one of each topic, or a copy in another layout, a smaller one (Zstandard).

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};

use super::definition::Definition;
use super::values::{plain, read};
use super::writer::REPEATED;
use super::{Bag, BagError, BagWriter, Preset, WriterOptions};

/// What was made.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Exported {
    /// Files of tables, or the new bag.
    pub paths: Vec<PathBuf>,
    /// Messages in them.
    pub messages: u64,
    /// Topics that could not be written as tables, and why.
    pub left_out: Vec<(String, String)>,
}

/// A table of each topic of `bag`, in the new directory `into`: a line for each message with its log time and publication time (ns since 1970) and each of its
/// values, in the units of the message. Elements of arrays have a column each, up to `longest`; longer ones are one text. Numbers read back to the same bits.
///
/// # Errors
/// The bag cannot be read, or the directory is there already or cannot be written; then none is left.
pub fn to_csv(bag: &Bag, into: &Path, longest: usize) -> Result<Exported, BagError> {
    match fs::create_dir(into) {
        Ok(()) => {}
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
            return Err(BagError::Exists { path: into.to_owned() });
        }
        Err(e) => return Err(BagError::io("create", into, e)),
    }
    let outcome = tables(bag, into, longest);
    if outcome.is_err() {
        // Ours, made a moment ago, and half done.
        drop(fs::remove_dir_all(into));
    }
    outcome
}

/// The table of one topic.
struct Table {
    definition: Definition,
    path: PathBuf,
    columns: Vec<String>,
    numbers: BTreeMap<String, usize>,
    file: Option<BufWriter<File>>,
}

fn tables(bag: &Bag, into: &Path, longest: usize) -> Result<Exported, BagError> {
    let mut exported = Exported::default();
    let mut tables: Vec<Option<Table>> = Vec::new();
    for (topic, &count) in bag.topics().iter().zip(bag.message_counts()) {
        let table = match Definition::parse(&topic.type_name, &topic.definition) {
            Ok(definition) => {
                // A topic's name has no point in it, so no two have the same file.
                let name = format!("{}.csv", topic.name.trim_start_matches('/').replace('/', "."));
                let (columns, numbers) = (Vec::new(), BTreeMap::new());
                Some(Table { definition, path: into.join(name), columns, numbers, file: None })
            }
            Err(reason) => {
                exported.left_out.push((topic.name.clone(), reason));
                None
            }
        };
        tables.push(table.filter(|_| count > 0));
    }
    let progress = progress(bag.message_counts().iter().sum::<u64>() * 2);
    // Once for the columns, which the longest array of the bag decides, and once for the lines.
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message()? {
        progress.inc(1);
        let Some(place) = tables.get_mut(message.topic) else { continue };
        let Some(table) = place else { continue };
        let Table { definition, columns, numbers, .. } = table;
        let outcome = read(definition, &message.data, longest, &mut |path, _| {
            if !numbers.contains_key(path) {
                numbers.insert(path.to_owned(), columns.len());
                columns.push(path.to_owned());
            }
        });
        if let Err(reason) = outcome {
            let topic = &bag.topics()[message.topic].name;
            exported.left_out.push((topic.clone(), format!("message {}: {reason}", message.sequence)));
            *place = None;
        }
    }
    let mut messages = bag.messages();
    let mut values = Vec::new();
    while let Some(message) = messages.next_message()? {
        progress.inc(1);
        let Some(Some(table)) = tables.get_mut(message.topic) else { continue };
        values.clear();
        values.resize(table.columns.len(), String::new());
        let numbers = &table.numbers;
        // It was read once, and is read alike again.
        let _ = read(&table.definition, &message.data, longest, &mut |path, value| {
            if let Some(place) = numbers.get(path).and_then(|&number| values.get_mut(number)) {
                *place = plain(&value);
            }
        });
        let failed = |e| BagError::io("write", &table.path, e);
        let mut file = match table.file.take() {
            Some(file) => file,
            None => {
                let mut file = BufWriter::new(File::create_new(&table.path).map_err(failed)?);
                line(&mut file, ["log_time_ns", "publish_time_ns"].map(String::from), &table.columns)
                    .map_err(failed)?;
                file
            }
        };
        let times = [message.log_time_ns.to_string(), message.publish_time_ns.to_string()];
        line(&mut file, times, &values).map_err(failed)?;
        table.file = Some(file);
        exported.messages += 1;
    }
    for table in tables.into_iter().flatten() {
        let Some(mut file) = table.file else { continue };
        file.flush().map_err(|e| BagError::io("write", &table.path, e))?;
        exported.paths.push(table.path);
    }
    progress.finish_and_clear();
    Ok(exported)
}

/// One line of a table; what has a comma, a quotation mark or a line end in it is quoted (RFC 4180).
fn line(file: &mut impl Write, times: [String; 2], values: &[String]) -> std::io::Result<()> {
    let quoted = |value: &String| {
        if value.contains(['"', ',', '\n', '\r']) {
            format!("\"{}\"", value.replace('"', "\"\""))
        } else {
            value.clone()
        }
    };
    let values: Vec<String> = times.iter().chain(values).map(quoted).collect();
    file.write_all(values.join(",").as_bytes())?;
    file.write_all(b"\r\n")
}

/// A copy of `bag` in another layout, compressed for example: the same messages with the same times and numbers, in one file.
///
/// # Errors
/// The bag cannot be read, or the new one exists already or cannot be written; then none is left.
pub fn to_bag(bag: &Bag, into: &Path, preset: Preset) -> Result<Exported, BagError> {
    let mut writer = BagWriter::create(into, &WriterOptions { preset, ..WriterOptions::default() })?;
    let progress = progress(bag.message_counts().iter().sum());
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

/// A bar for people who look on.
fn progress(messages: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {human_pos} of {human_len} messages (eta {eta})");
    let bar = ProgressBar::new(messages);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
