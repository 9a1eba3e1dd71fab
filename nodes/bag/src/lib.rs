// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bags: rosbag2 directories with MCAP storage, as ROS 2 Jazzy writes and reads them.
//!
//! ```text
//!   topics, messages ──► Recording ──queue──► BagWriter ──► <bag>/metadata.yaml
//!   (the node's thread)   (counts)  (thread)               <bag>/<bag>_0.mcap, _1 …
//!                                                                │
//!          info, check, export, report, replay ◄── Bag ◄───────────┤
//!                        recover: a new bag ◄── Salvage ◄────────┘  (not closed, or damaged)
//! ```
//!
//! Nothing here knows ROS: a message is the bytes that travelled, a type is its name, hash and definition text.

pub mod progress;

mod channels;
pub mod check;
mod columns;
mod csv;
pub mod definition;
pub mod disk_reserve;
mod durations;
pub mod export;
mod exported;
pub mod info;
mod json;
mod latched;
pub mod metadata;
mod parquet_file;
mod preset;
pub mod qos;
pub mod reader;
pub mod recording;
mod recording_options;
mod recording_state;
mod records;
pub mod recover;
mod salvage;
pub mod schema_evolution;
mod sequence_check;
mod snapshot;
mod storage_file;
mod tables;
pub mod terminal;
mod values;
mod well_formed;
pub mod writer;
mod writer_task;
mod yaml;

use std::io;
use std::path::{Path, PathBuf};

#[cfg(test)]
mod tests;

pub use durations::DurationSummary;
pub use metadata::{BagMetadata, FileEntry, TopicEntry};
pub use preset::CHUNK_BYTES;
pub use preset::Preset;
pub use qos::QosProfile;
pub use reader::{Bag, BagMessage, Messages};
pub use recording::{Counts, Recording, TopicCounts};
pub use snapshot::SnapshotOptions;
pub use writer::{BagWriter, RecordingOutcome, SplitLimits, TopicId, WriterOptions};
pub use writer_task::free_bytes;

/// One topic as a bag knows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Fully qualified name, for example `/joint_states`.
    pub name: String,
    /// ROS type, for example `sensor_msgs/msg/JointState`.
    pub type_name: String,
    /// Type hash `RIHS01_` and 64 hexadecimal digits; empty when unknown.
    pub type_hash: String,
    /// The type's definition and those of all types it uses, in the bag's `ros2msg` form.
    pub definition: String,
    /// Offered quality of service, one entry per publisher.
    pub offered_qos: Vec<QosProfile>,
}

impl Topic {
    /// Returns whether late subscribers of this topic receive earlier messages.
    #[must_use]
    pub fn is_latched(&self) -> bool {
        self.offered_qos.iter().any(|offer| offer.durability == qos::Durability::TransientLocal)
    }
}

/// Why a bag could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// The directory is there already.
    #[error("bag {} already exists, and a recording never overwrites one", path.display())]
    Exists { path: PathBuf },
    /// The path cannot name a bag.
    #[error("{} cannot name a bag: it has no last component in UTF-8", path.display())]
    Name {
        /// The path as given.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// Attempted action, as a verb.
        action: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// No room for the bytes a recording keeps back to close its bag with, or less than it has to leave free.
    #[error("cannot record into {}: fewer than {needed} bytes are free there", path.display())]
    NoRoom {
        path: PathBuf,
        /// Required space of a recording (B).
        needed: u64,
    },
    /// The MCAP file is damaged or of a form not supported.
    #[error("{}: {}", path.display(), mcap_reason(source))]
    Mcap {
        path: PathBuf,
        /// Error of the MCAP library.
        source: mcap::McapError,
    },
    /// `metadata.yaml` is missing.
    #[error("{} has no metadata.yaml", path.display())]
    NoMetadata { path: PathBuf },
    /// `metadata.yaml` cannot be understood.
    #[error("{}: {reason}", path.display())]
    Metadata {
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// A topic is added a second time as another type.
    #[error("topic {topic} is in the bag as {was} and cannot also be {now}")]
    TypeChanged {
        topic: String,
        /// Its type in the bag.
        was: String,
        /// The type asked for.
        now: String,
    },
    /// A table cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Table {
        path: PathBuf,
        /// Error of the Parquet library.
        source: parquet::errors::ParquetError,
    },
    /// The bag was closed before, by a fault.
    #[error("the bag is closed: {reason}")]
    Closed {
        /// Why it was closed.
        reason: String,
    },
}

impl BagError {
    fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }

    fn mcap(path: &Path, source: mcap::McapError) -> Self {
        Self::Mcap { path: path.to_owned(), source }
    }
}

/// A path beside a bag, under the bag's name with a word behind it.
pub fn named_beside(path: &Path, word: &str) -> PathBuf {
    let name = path.file_stem().map_or_else(|| "bag".to_owned(), |name| name.to_string_lossy().into_owned());
    path.with_file_name(format!("{name}_{word}"))
}

/// Error text of the MCAP library, with the cause that its own text omits.
fn mcap_reason(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(source) => source.to_string(),
        mcap::McapError::Parse(source) => format!("a record cannot be parsed: {source}"),
        other => {
            let text = other.to_string();
            let mut letters = text.chars();
            match letters.next() {
                Some(first) => first.to_lowercase().chain(letters).collect(),
                None => text,
            }
        }
    }
}
