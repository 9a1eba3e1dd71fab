// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `~/get_logger_levels` and `~/set_logger_levels`: the levels of a node's logger, read and changed while it runs.

use camwright_msgs::rcl_interfaces::{
    msg::{LoggerLevel, SetLoggerLevelsResult},
    srv::{GetLoggerLevels, GetLoggerLevelsResponse, SetLoggerLevels, SetLoggerLevelsResponse},
};

use super::{error::RosError, level::Level, logging::Logger, node::Node, qos::Qos};

/// Offers both services. A node has one logger, under its own name; the level of another logger is unknown (0).
pub(super) fn offer(node: &Node) -> Result<(), RosError> {
    let logger = node.logger().clone();
    node.retain(node.builtin_service::<GetLoggerLevels>("get_logger_levels", &Qos::services(), move |request| {
        let level = |name: &String| if *name == logger.name() { logger.level() as u32 } else { 0 };
        let levels = request.names.iter().map(|name| LoggerLevel { name: name.clone(), level: level(name) }).collect();
        GetLoggerLevelsResponse { levels }
    })?);
    let logger = node.logger().clone();
    node.retain(node.builtin_service::<SetLoggerLevels>("set_logger_levels", &Qos::services(), move |request| {
        let results = request.levels.iter().map(|wanted| match set(&logger, wanted) {
            Ok(()) => SetLoggerLevelsResult { successful: true, reason: String::new() },
            Err(reason) => SetLoggerLevelsResult { successful: false, reason },
        });
        SetLoggerLevelsResponse { results: results.collect() }
    })?);
    Ok(())
}

fn set(logger: &Logger, wanted: &LoggerLevel) -> Result<(), String> {
    if wanted.name != logger.name() {
        return Err(format!("this node has no logger '{}'; its logger is '{}'", wanted.name, logger.name()));
    }
    let level = Level::from_number(wanted.level).ok_or_else(|| {
        format!(
            "level {} of logger '{}' is unknown; allowed: 10 (debug), 20 (info), 30 (warn), 40 (error), 50 (fatal), and 0 \
             for the level of the start",
            wanted.level, wanted.name
        )
    })?;
    logger.set_level(level);
    Ok(())
}
