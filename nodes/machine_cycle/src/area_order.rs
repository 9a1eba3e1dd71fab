// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Orders to door, chuck and part of a machine that is loaded.

/// Order for door, chuck or part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AreaOrder {
    /// Open it, or close it.
    Door(bool),
    Chuck(bool),
    /// Put a part in, or take it out.
    Part(bool),
}

impl AreaOrder {
    pub const ALL: [(&'static str, AreaOrder); 6] = [
        ("machine/open_door", AreaOrder::Door(true)),
        ("machine/close_door", AreaOrder::Door(false)),
        ("machine/open_chuck", AreaOrder::Chuck(true)),
        ("machine/close_chuck", AreaOrder::Chuck(false)),
        ("machine/place_part", AreaOrder::Part(true)),
        ("machine/take_part", AreaOrder::Part(false)),
    ];

    /// The service that asks for it.
    pub fn service(self) -> &'static str {
        Self::ALL.iter().find(|(_, order)| *order == self).map_or("", |(name, _)| name)
    }

    /// Order of a service.
    pub fn from_service(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, order)| *order)
    }

    /// Sentence that reports the order as done.
    pub const fn done(self) -> &'static str {
        match self {
            AreaOrder::Door(true) => "the door opens",
            AreaOrder::Door(false) => "the door closes",
            AreaOrder::Chuck(true) => "the chuck opens",
            AreaOrder::Chuck(false) => "the chuck closes",
            AreaOrder::Part(true) => "a part is in the chuck",
            AreaOrder::Part(false) => "the part is out of the chuck",
        }
    }
}
