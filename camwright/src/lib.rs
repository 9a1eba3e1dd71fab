//! From a lift table to axis motion, and from axis motion to the part: the mathematics of machining what is not round.
//!
//! Inside: mm, rad, s, N, unless a name says otherwise. No ROS, no file, no clock, no thread: time is a tick.
#![no_std]
extern crate alloc;

pub mod archimedean;
pub mod capability;
pub mod cell;
pub mod compensation;
pub mod contact_law;
pub mod contour;
pub mod cut_motion;
pub mod cutter_path;
pub mod cycle;
pub mod dressing;
pub mod fault_campaign;
pub mod follower;
pub mod form;
pub mod giving_way;
pub mod groove;
pub mod infeed;
pub mod insert_clearance;
pub mod insert_path;
pub mod inspection;
pub mod interpolator;
pub mod job;
pub mod keyframe;
pub mod lift;
pub mod loading;
pub mod machine;
pub mod milling_job;
pub mod motion_law;
pub mod nc;
pub mod numeric;
pub mod packml;
pub mod path_stop;
pub mod plan;
pub mod plan_check;
pub mod plan_difference;
pub mod point_to_point;
pub mod post;
pub mod program_motion;
pub mod rake_section;
pub mod raw_part;
pub mod rehearsal;
pub mod runout;
pub mod setpoint;
pub mod speed_plan;
pub mod spiral_motion;
pub mod surface;
pub mod tool_path;
pub mod turning_drives;
pub mod turning_job;
pub mod units;
pub mod wheel;
