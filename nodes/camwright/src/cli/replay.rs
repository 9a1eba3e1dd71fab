//! `camwright replay`: plays a bag to the graph, or recomputes its run.

use camwright_analysis::rerun::Window;
use camwright_ros::RosArgs;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `camwright replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = super::help::REPLAY)]
pub(super) struct ReplayCommand {
    #[command(flatten)]
    play: crate::player::ReplayArgs,
    /// Recompute the run from its inputs and compare it bit by bit; with BAG also compare both runs
    #[arg(long, value_name = "BAG", num_args = 0..=1)]
    #[allow(clippy::option_option, reason = "the flag, and its value")]
    against: Option<Option<PathBuf>>,
    /// With --against: start at the last keyframe before this tick
    #[arg(long, value_name = "TICK", requires = "against")]
    from_tick: Option<u64>,
    /// With --against: stop at this tick
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
