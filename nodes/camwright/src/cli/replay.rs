//! `camwright replay`: plays a bag to the graph, or computes its run again.

use camwright_analysis::rerun::Window;
use camwright_ros::RosArgs;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct ReplayCommand {
    #[command(flatten)]
    play: crate::player::ReplayArgs,
    /// Play nothing, but compute the run again from its inputs and say whether it is the same to the bit; with another bag, whether that
    /// holds the same jobs too. Exit code 0: the same; 3: not, with the first tick that differs; 1: the bag does not hold what it takes
    #[arg(long, value_name = "BAG", num_args = 0..=1)]
    #[allow(clippy::option_option, reason = "the flag, and its value")]
    against: Option<Option<PathBuf>>,
    /// With --against: from the middle, from the last keyframe up to this tick of the machine
    #[arg(long, value_name = "TICK", requires = "against")]
    from_tick: Option<u64>,
    /// With --against: up to this tick of the machine
    #[arg(long, value_name = "TICK", requires = "against")]
    to_tick: Option<u64>,
}

pub(super) fn main(args: &ReplayCommand, ros: &RosArgs) -> ExitCode {
    match &args.against {
        Some(other) => {
            let window = Window { from_tick: args.from_tick, to_tick: args.to_tick };
            camwright_analysis::rerun::run(&args.play.bag, other.as_deref(), window)
        }
        None => crate::player::run(&args.play, ros),
    }
}
