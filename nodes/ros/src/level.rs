// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Severities of log lines.

/// Severity, with the numbers of `rcl_interfaces/msg/Log`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Level {
    Unset = 0,
    Debug = 10,
    /// Normal operation.
    Info = 20,
    /// Unusual, but the node goes on.
    Warn = 30,
    /// Failed operation.
    Error = 40,
    /// Failure that ends the process.
    Fatal = 50,
}

impl Level {
    /// Level of a name, in any case.
    pub fn from_name(name: &str) -> Option<Self> {
        [Level::Unset, Level::Debug, Level::Info, Level::Warn, Level::Error, Level::Fatal]
            .into_iter()
            .find(|level| level.name().eq_ignore_ascii_case(name))
    }

    /// Level of a number.
    pub fn from_number(number: u32) -> Option<Self> {
        [Level::Unset, Level::Debug, Level::Info, Level::Warn, Level::Error, Level::Fatal]
            .into_iter()
            .find(|level| *level as u32 == number)
    }

    /// Name as ROS prints it.
    pub fn name(self) -> &'static str {
        match self {
            Level::Unset => "UNSET",
            Level::Debug => "DEBUG",
            Level::Info => "INFO",
            Level::Warn => "WARN",
            Level::Error => "ERROR",
            Level::Fatal => "FATAL",
        }
    }
}

impl From<tracing::Level> for Level {
    fn from(level: tracing::Level) -> Self {
        match level {
            tracing::Level::ERROR => Level::Error,
            tracing::Level::WARN => Level::Warn,
            tracing::Level::INFO => Level::Info,
            _ => Level::Debug,
        }
    }
}
