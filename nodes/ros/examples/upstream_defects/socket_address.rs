// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A participant of the loopback interface binds its sockets to 0.0.0.0 and so receives from every interface.

use super::common::{Checked, Verdict, participant, text};

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let port = 7400 + 250 * participant.domain_id() + 10 + 2 * participant.participant_id();
    let sockets = std::fs::read_to_string("/proc/self/net/udp").map_err(text)?;
    let of_port = |port: u16| {
        let suffix = format!(":{port:04X}");
        sockets.lines().filter_map(|line| line.split_whitespace().nth(1)).find(|address| address.ends_with(&suffix))
    };
    let (Some(discovery), Some(user_traffic)) = (of_port(port), of_port(port + 1)) else {
        return Err(format!("no result: no socket on port {port} or {}", port + 1));
    };
    let is_any = |address: &str| address.starts_with("00000000:");
    Ok(Verdict::pass_if(!is_any(discovery) && !is_any(user_traffic), || {
        format!("with_only_networks([127.0.0.1]) bound ports {port} and {} to 0.0.0.0", port + 1)
    }))
}
