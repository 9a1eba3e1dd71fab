// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages of the cell: its state, and that of the loading.

use super::Shared;
use super::controller::CellController;
use camwright::cell::loading::Handshake;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::{CellState, LoadingState};

impl CellController {
    /// Says what has changed.
    pub(super) fn publish(&mut self, shared: &Shared) {
        let state = self.cell_state(shared);
        let loading = self.area.is_some().then(|| self.loading_state(shared));
        let (now_s, real_s) = (self.now_s(), self.real_s());
        let unit = self.unit;
        let left_s = self.handshake.as_ref().map_or(Some(0.0), |handshake| handshake.timeout_left_s(real_s));
        let now: Time = shared.node.now();
        let published = self.publisher.state.publish(state, &now, |state, stamp| CellState {
            stamp,
            time_in_state: unit.time_in_state_s(now_s),
            accumulated: unit.accumulated_s(now_s),
            ..state
        });
        let published = published.and_then(|()| match loading {
            Some(loading) => self.publisher.loading.publish(loading, &now, |loading, stamp| LoadingState {
                stamp,
                timeout_left: left_s.unwrap_or(-1.0),
                ..loading
            }),
            None => Ok(()),
        });
        if let Err(error) = published {
            shared.node.logger().warn(&error.to_string());
        }
    }

    fn cell_state(&self, shared: &Shared) -> CellState {
        let (state, mode) = (self.unit.state(), self.unit.mode());
        let (wanted, done) = self.parts;
        CellState {
            state: state as u8,
            state_name: state.name().to_owned(),
            mode: mode as u8,
            mode_name: mode.name().to_owned(),
            substate: self.substate.clone(),
            stop_reason: self.reason.text.clone(),
            alarm: self.reason.alarm,
            remedy: self.reason.remedy.clone(),
            job: self.job.clone(),
            holder: self.holder(shared),
            parts_wanted: wanted,
            parts_done: done,
            life: self.counters.life.clone(),
            shift: self.counters.shift.clone(),
            ..CellState::default()
        }
    }

    fn loading_state(&self, shared: &Shared) -> LoadingState {
        let area = self.area.clone().unwrap_or_default();
        let asks = matches!(self.unit.state(), camwright::cell::packml::PackmlState::Suspended);
        let handshake = self.handshake.as_ref();
        LoadingState {
            request: handshake.filter(|_| asks).map_or(LoadingState::NONE, |handshake| handshake.request() as u8),
            step: self.step().to_owned(),
            door: area.door,
            chuck: area.chuck,
            part_present: area.part_present,
            clear_to_enter: handshake.is_some_and(Handshake::clear_to_enter),
            robot_in_work_area: self.is_inside(),
            robot_is_heard: self.loader_state(shared).is_some(),
            message: self.substate.clone(),
            ..LoadingState::default()
        }
    }
}
