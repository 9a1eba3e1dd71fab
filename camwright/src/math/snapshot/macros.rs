// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Macros that declare the state of structures and enums.

/// A structure: its state, and what that stands on, which is made anew and not written. After `holds` what must be so of a state that
/// was read.
///
/// ```
/// use camwright::math::snapshot::{Snapshot, SnapshotCodec};
///
/// #[derive(Default)]
/// struct Slide { position: f64, moves: bool, limit: f64 }
/// camwright::snapshot!(Slide { position, moves } on { limit } holds |slide| {
///     slide.position.abs() <= 1e6 => "it is nowhere",
/// });
///
/// let mut octets = [0; 9];
/// Slide { position: 2.5, moves: true, limit: 9.0 }.snapshot(&mut SnapshotCodec::writing(&mut octets)).unwrap();
/// let mut again = Slide { limit: 9.0, ..Slide::default() };
/// again.snapshot(&mut SnapshotCodec::reading(&octets)).unwrap();
/// assert_eq!((again.position, again.moves, again.limit), (2.5, true, 9.0));
/// ```
#[macro_export]
macro_rules! snapshot {
    (
        $type:ty { $($state:ident),* $(,)? } on { $($basis:ident),* $(,)? }
        $(holds |$this:ident| { $($holds:expr => $what:literal),+ $(,)? })?
    ) => {
        impl $crate::math::snapshot::Snapshot for $type {
            fn snapshot(&mut self, codec: &mut $crate::math::snapshot::SnapshotCodec<'_>) -> Result<(), $crate::math::snapshot::SnapshotError> {
                let Self { $($state,)* $($basis: _,)* } = self;
                $( codec.field(stringify!($state), |codec| $crate::math::snapshot::Snapshot::snapshot($state, codec))?; )*
                $(
                    let $this = &*self;
                    if codec.is_reading() {
                        $(
                            let holds: bool = $holds;
                            if !holds {
                                return Err($crate::math::snapshot::SnapshotError::Impossible($what));
                            }
                        )+
                    }
                )?
                Ok(())
            }
        }
    };
}

/// Cases, each with its number, and what each carries.
#[macro_export]
macro_rules! snapshot_cases {
    ($type:ty { $($number:literal $case:ident $(( $($item:ident),+ ))? $({ $($field:ident),+ })?),+ $(,)? }) => {
        impl $crate::math::snapshot::Snapshot for $type {
            fn snapshot(&mut self, codec: &mut $crate::math::snapshot::SnapshotCodec<'_>) -> Result<(), $crate::math::snapshot::SnapshotError> {
                let mut number: u8 = match self { $( Self::$case { .. } => $number, )+ };
                $crate::math::snapshot::Snapshot::snapshot(&mut number, codec)?;
                if codec.is_reading() {
                    *self = match number {
                        $( $number => Self::$case
                            $(( $( { let $item = Default::default(); $item } ),+ ))?
                            $({ $( $field: Default::default() ),+ })?, )+
                        _ => return Err($crate::math::snapshot::SnapshotError::Impossible("there is no such case")),
                    };
                }
                match self {
                    $( Self::$case $(( $($item),+ ))? $({ $($field),+ })? => {
                        $( $( codec.field(stringify!($item), |codec| $crate::math::snapshot::Snapshot::snapshot($item, codec))?; )+ )?
                        $( $( codec.field(stringify!($field), |codec| $crate::math::snapshot::Snapshot::snapshot($field, codec))?; )+ )?
                    } )+
                }
                Ok(())
            }
        }
    };
}
