//! Room cam.

pub mod capability;
pub mod compensation;
pub mod contour;
pub mod follower;
pub mod form;
pub mod inspection;
pub mod lift;
pub mod motion_law;
pub mod surface;
