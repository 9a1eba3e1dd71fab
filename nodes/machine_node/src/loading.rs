// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A raw part on its way to the machine: the services that put it in, and what the cyclic thread says of it.

use super::{CycleInlet, PendingRequests, pop, push};
use camwright_machine_cycle::messages::{Inbound, Outbound};
use camwright_machine_cycle::part::{LobeRefused, RawBar, RawLobe};
use camwright_msgs::camwright_msgs::srv::{LoadBar, LoadBarResponse, LoadLobe, LoadLobeResponse};
use camwright_ros::{Node, RosError, ServiceHandle};
use std::sync::Arc;

/// Requests that the cyclic thread has yet to answer.
#[derive(Debug, Clone, Default)]
pub(super) struct Loads {
    lobes: PendingRequests<LoadLobe>,
    bars: PendingRequests<LoadBar>,
}

impl Loads {
    /// Passes the cyclic thread's result for a raw part to the client.
    pub(super) fn answer(&self, message: Outbound) {
        match message {
            Outbound::LobeDone(outcome, lobe) => {
                let (success, message) = match outcome {
                    Ok(()) => (true, String::new()),
                    Err(LobeRefused::Moving) => (false, format!("lobe {}: the machine is not at rest", lobe.name)),
                    Err(LobeRefused::NotHeld(refused)) => (false, format!("lobe {}: {refused}", lobe.name)),
                    Err(LobeRefused::Part(error)) => (false, error.to_string()),
                };
                if let Some(responder) = pop(&self.lobes) {
                    responder.send(&LoadLobeResponse { success, message });
                }
            }
            Outbound::BarDone(outcome, bar) => {
                let (success, message) = match outcome {
                    Ok(()) => (true, String::new()),
                    Err(reason) => (false, format!("part {}: {reason}", bar.name)),
                };
                if let Some(responder) = pop(&self.bars) {
                    responder.send(&LoadBarResponse { success, message });
                }
            }
            _ => {}
        }
    }
}

pub(super) fn offer(node: &Node, inlet: &CycleInlet, loads: &Loads) -> Result<[ServiceHandle; 2], RosError> {
    let (way, waiting) = (inlet.clone(), Arc::clone(&loads.lobes));
    let lobe = node.service_deferred::<LoadLobe>("machine/load_lobe", move |request, responder| {
        push(&waiting, responder.or_fail(|message| LoadLobeResponse { success: false, message }));
        way.send(Inbound::Lobe(Box::new(RawLobe::new(request))));
    })?;
    let (way, waiting) = (inlet.clone(), Arc::clone(&loads.bars));
    let bar =
        node.service_deferred::<LoadBar>("machine/load_bar", move |request, responder| match RawBar::new(request) {
            Ok(bar) => {
                push(&waiting, responder.or_fail(|message| LoadBarResponse { success: false, message }));
                way.send(Inbound::Bar(Box::new(bar)));
            }
            Err(message) => responder.send(&LoadBarResponse { success: false, message }),
        })?;
    Ok([lobe, bar])
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_msgs::camwright_msgs::srv::LoadBarRequest;

    fn refusal(request: &LoadBarRequest) -> String {
        RawBar::new(request.clone()).expect_err("it is refused")
    }

    #[test]
    fn a_bar_is_made_as_asked_and_refused_before_memory_is_taken() {
        let good = LoadBarRequest {
            name: "cam".into(),
            radius: 0.0232,
            azimuths: 360,
            columns: 201,
            to_z: 0.004,
            ..LoadBarRequest::default()
        };
        let part = RawBar::new(good.clone()).expect("a bar").part.expect("it is there");
        assert!((part.radius_mm(7, 100) - 23.2).abs() < 1e-12 && (part.grid().to_mm - 4.0).abs() < 1e-12);
        let huge = LoadBarRequest { azimuths: u32::MAX, columns: u32::MAX, ..good.clone() };
        assert!(refusal(&huge).contains("at most 2097152 are allowed"), "{}", refusal(&huge));
        let empty = LoadBarRequest { columns: 0, ..good.clone() };
        assert!(refusal(&empty).contains("at least 16 and 2"), "{}", refusal(&empty));
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let message = refusal(&LoadBarRequest { radius, ..good.clone() });
            assert!(message.contains("must be positive and finite"), "{message}");
        }
        let nowhere = LoadBarRequest { to_z: f64::NAN, ..good };
        assert!(refusal(&nowhere).contains("must increase and be finite"), "{}", refusal(&nowhere));
    }
}
