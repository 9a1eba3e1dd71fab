//! The ROS 2 shells around the `camwright` core.

pub mod axis_interpolator;
pub mod bag;
pub mod bag_size;
pub mod cli;
pub mod config;
pub mod convert;
pub mod cyclic;
pub mod digest;
mod drawing;
pub mod job_planner;
mod liveness;
pub mod machine_check;
pub mod machine_sim;
pub mod operator_page;
pub mod planning;
mod progress;
mod realtime;
mod record_text;
pub mod replan;
pub mod replay;
pub mod report;
pub mod rerun;
pub mod ros;
pub mod run_logger;
pub mod running;
pub mod scene;
pub mod supervised;
