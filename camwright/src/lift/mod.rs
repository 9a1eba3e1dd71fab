//! Lift: what the follower does over one turn of the cam, as a printed table, as a formula, and as the law both give.

mod check;
mod error;
pub mod law;
pub mod program;
pub mod table;

pub use error::LiftError;
pub use law::{LiftLaw, LiftLawError, TableReading};
pub use program::{MotionProgram, MotionSegment, ProgramError};
pub use table::{AngleUnit, LiftDeclaration, LiftForm, LiftRow, LiftTable};
