//! Room toolpath.

pub mod cutter_path;
pub mod groove;
pub mod insert_clearance;
pub mod insert_path;
pub mod rake_section;
pub mod wheel_path;
