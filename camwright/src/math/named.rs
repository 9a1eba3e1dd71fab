// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Enums whose cases have names for messages.

/// Declares an enum with the name of each case, which it displays.
macro_rules! named {
    ($(#[$doc:meta])* $type:ident { $($case:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $type {
            $($case,)*
        }

        impl $type {
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$case => $text,)*
                }
            }
        }

        impl core::fmt::Display for $type {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

pub(crate) use named;
