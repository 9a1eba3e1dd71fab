//! Room motion.

pub mod cut_motion;
pub mod path_stop;
pub mod plan;
pub mod point_to_point;
pub(crate) mod speed_change;
pub mod speed_plan;
pub mod spiral_motion;
