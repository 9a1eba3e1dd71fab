// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Layout of the files of a bag, with rosbag2's names.

/// rosbag2's `DefaultChunkSize` (B), and that of its preset `zstd_small`.
pub const CHUNK_BYTES: u64 = 786_432;
const LARGE_CHUNK_BYTES: u64 = 4 << 20;
/// Levels of Zstandard that rosbag2's `Fastest` and `Slowest` stand for.
const FASTEST: i32 = -5;
const SLOWEST: i32 = 19;

/// Layout of a file, with rosbag2's names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preset {
    /// Chunks of 768 KiB without compression, with check sums.
    #[default]
    Default,
    /// The same chunks, compressed with Zstandard at its fast level 1.
    Zstd,
    /// The same chunks, compressed with Zstandard as fast as it can: the least work of those that compress.
    ZstdFast,
    /// Chunks of 4 MiB, compressed with Zstandard as far as it is bearable: many times the work, for what is kept for long.
    ZstdSmall,
    /// No chunks, hence no index: least work while recording, no seeking afterwards.
    FastWrite,
}

impl Preset {
    /// All of them, with their names.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("default", Self::Default),
        ("zstd", Self::Zstd),
        ("zstd_fast", Self::ZstdFast),
        ("zstd_small", Self::ZstdSmall),
        ("fastwrite", Self::FastWrite),
    ];

    /// The preset of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, preset)| *preset)
    }

    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, known)| *known == self).map_or("default", |(name, _)| name)
    }

    pub(super) fn write_options(self) -> mcap::WriteOptions {
        // Everything is said here: the library's own defaults compress on as many threads as the machine has.
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .library(concat!("camwright ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .use_chunks(true)
            // A chunk under way stays in memory, so that a kill leaves whole records and at most one torn one.
            .disable_seeking(true)
            .calculate_chunk_crcs(true)
            .calculate_data_section_crc(true)
            .calculate_summary_section_crc(true);
        // The library hands the level on as it is; below zero are the fast ones.
        let zstd = |level: i32| {
            let options = options.clone().compression(Some(mcap::Compression::Zstd));
            options.compression_level(level.cast_unsigned())
        };
        match self {
            Self::Default => options,
            Self::Zstd => zstd(1),
            Self::ZstdFast => zstd(FASTEST),
            Self::ZstdSmall => zstd(SLOWEST).chunk_size(Some(LARGE_CHUNK_BYTES)),
            Self::FastWrite => {
                options.use_chunks(false).emit_message_indexes(false).calculate_summary_section_crc(false)
            }
        }
    }
}
