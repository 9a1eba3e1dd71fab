//! How structures and cases say what of them is state.

/// A structure: its state, and what that stands on, which is made anew and not written. After `holds` what must be so of a state that
/// was read.
///
/// ```
/// use camwright::math::snapshot::{Kept, Tape};
///
/// #[derive(Default)]
/// struct Slide { position: f64, moves: bool, limit: f64 }
/// camwright::kept!(Slide { position, moves } on { limit } holds |slide| {
///     slide.position.abs() <= 1e6 => "it is nowhere",
/// });
///
/// let mut octets = [0; 9];
/// Slide { position: 2.5, moves: true, limit: 9.0 }.keep(&mut Tape::writing(&mut octets)).unwrap();
/// let mut again = Slide { limit: 9.0, ..Slide::default() };
/// again.keep(&mut Tape::reading(&octets)).unwrap();
/// assert_eq!((again.position, again.moves, again.limit), (2.5, true, 9.0));
/// ```
#[macro_export]
macro_rules! kept {
    (
        $type:ty { $($state:ident),* $(,)? } on { $($basis:ident),* $(,)? }
        $(holds |$this:ident| { $($holds:expr => $what:literal),+ $(,)? })?
    ) => {
        impl $crate::math::snapshot::Kept for $type {
            fn keep(&mut self, tape: &mut $crate::math::snapshot::Tape<'_>) -> Result<(), $crate::math::snapshot::TapeError> {
                let Self { $($state,)* $($basis: _,)* } = self;
                $( tape.field(stringify!($state), |tape| $crate::math::snapshot::Kept::keep($state, tape))?; )*
                $(
                    let $this = &*self;
                    if tape.is_reading() {
                        $(
                            let holds: bool = $holds;
                            if !holds {
                                return Err($crate::math::snapshot::TapeError::Impossible($what));
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
macro_rules! kept_cases {
    ($type:ty { $($number:literal $case:ident $(( $($item:ident),+ ))? $({ $($field:ident),+ })?),+ $(,)? }) => {
        impl $crate::math::snapshot::Kept for $type {
            fn keep(&mut self, tape: &mut $crate::math::snapshot::Tape<'_>) -> Result<(), $crate::math::snapshot::TapeError> {
                let mut number: u8 = match self { $( Self::$case { .. } => $number, )+ };
                $crate::math::snapshot::Kept::keep(&mut number, tape)?;
                if tape.is_reading() {
                    *self = match number {
                        $( $number => Self::$case
                            $(( $( { let $item = Default::default(); $item } ),+ ))?
                            $({ $( $field: Default::default() ),+ })?, )+
                        _ => return Err($crate::math::snapshot::TapeError::Impossible("there is no such case")),
                    };
                }
                match self {
                    $( Self::$case $(( $($item),+ ))? $({ $($field),+ })? => {
                        $( $( tape.field(stringify!($item), |tape| $crate::math::snapshot::Kept::keep($item, tape))?; )+ )?
                        $( $( tape.field(stringify!($field), |tape| $crate::math::snapshot::Kept::keep($field, tape))?; )+ )?
                    } )+
                }
                Ok(())
            }
        }
    };
}
