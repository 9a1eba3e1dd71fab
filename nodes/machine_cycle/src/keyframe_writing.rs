// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Keyframes of the cyclic thread: when one is due, and its writing.

use super::cyclic_loop::CyclicLoop;
use super::keyframes::{Keyframes, MAX_MOVING, Room, SLACK};
use super::messages::Outbound;
use camwright::math::snapshot::SnapshotCodec;

impl CyclicLoop {
    /// With keyframes from now on.
    pub fn with_keyframes(mut self, keyframes: Keyframes) -> Self {
        self.keyframes = keyframes;
        if self.keyframes.period_s > 0.0 {
            self.keyframes.room = Some(Room::with_size(0));
            self.keyframes.due = self.keyframes.ticks();
        }
        self.measure_keyframe();
        self
    }

    /// A part was taken: there is room for it. Called where allocating is allowed, at rest.
    pub fn measure_keyframe(&mut self) {
        let mut codec = SnapshotCodec::measuring();
        if self.keyframes.period_s <= 0.0 || self.walk_keyframe(&mut codec).is_err() {
            return;
        }
        self.keyframes.size = codec.octets();
        if let Some(room) = self.keyframes.room.as_mut().filter(|room| room.octets.len() < codec.octets() + SLACK) {
            *room = Room::with_size(codec.octets());
        }
    }

    /// A tick is over: writes a keyframe if one is due.
    pub fn write_keyframe(&mut self) {
        let tick = self.machine.tick();
        if self.keyframes.period_s <= 0.0 || tick < self.keyframes.due {
            return;
        }
        let rests = self.machine.is_at_rest() && !self.buffer.has_setpoints();
        if self.keyframes.by_the_clock && self.keyframes.size > MAX_MOVING && !rests {
            return;
        }
        let Some(mut room) = self.keyframes.room.take() else { return };
        let mut codec = SnapshotCodec::writing(&mut room.octets);
        let written = self.walk_keyframe(&mut codec);
        room.written = written.map(|()| codec.octets()).map_err(|error| (error, codec.place()));
        let ticks = self.keyframes.ticks().max(1);
        self.keyframes.due = (tick / ticks + 1).saturating_mul(ticks);
        self.send(Outbound::Keyframe(room));
    }
}
