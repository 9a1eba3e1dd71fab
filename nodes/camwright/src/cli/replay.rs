// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright replay`: plays a bag to the graph, or recomputes its run.

use super::output::{VerdictLevel, note, print_error, print_verdict, say, whole_number, wrapped};
use crate::player::{self, PlaybackSummary, ReplayError};
use camwright_analysis::rerun::{self, Window};
use camwright_ros::{RosArgs, Shutdown};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `camwright replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = super::help::REPLAY)]
pub(super) struct ReplayCommand {
    #[command(flatten)]
    play: player::ReplayArgs,
    /// Recompute the run from its inputs and compare it bit by bit; with BAG also compare both runs
    #[arg(long, value_name = "BAG", num_args = 0..=1)]
    #[allow(clippy::option_option, reason = "the flag, and its value")]
    against: Option<Option<PathBuf>>,
    /// With --against: start at the last keyframe before this tick
    #[arg(long, value_name = "TICK", requires = "against", value_parser = tick)]
    from_tick: Option<u64>,
    /// With --against: stop at this tick
    #[arg(long, value_name = "TICK", requires = "against", value_parser = tick)]
    to_tick: Option<u64>,
    /// With --against: print one JSON object instead of text
    #[arg(long, requires = "against")]
    json: bool,
}

fn tick(text: &str) -> Result<u64, String> {
    whole_number(text, 0..=u64::MAX)
}

/// Exit code of a run that differs.
const DIFFERENT: u8 = 3;

/// Exit code of playing 0: played, or ended by Ctrl-C; 2: not played. Of a comparison 0: the same; 3: different; 1: cannot be computed.
pub(super) fn main(args: &ReplayCommand, ros: &RosArgs) -> ExitCode {
    match &args.against {
        Some(other) => compare(args, other.as_deref()),
        None => play(args, ros),
    }
}

fn compare(args: &ReplayCommand, other: Option<&Path>) -> ExitCode {
    let (bag, window) = (&args.play.bag, Window { from_tick: args.from_tick, to_tick: args.to_tick });
    let compared = match rerun::against(bag, other, window) {
        Ok(compared) => compared,
        Err(error) => {
            print_error("camwright replay", &format!("cannot replay {}: {error}", bag.display()));
            return ExitCode::from(1);
        }
    };
    let code = if compared.is_same() { 0 } else { DIFFERENT };
    if args.json {
        say!("{:#}", compared.to_json());
    } else {
        print_verdict(VerdictLevel::from_code(code), &wrapped(&compared.to_text(), 2));
    }
    ExitCode::from(code)
}

fn play(args: &ReplayCommand, ros: &RosArgs) -> ExitCode {
    let played = Shutdown::on_signals().map_err(ReplayError::from);
    match played.and_then(|shutdown| player::play(&args.play, ros, &shutdown)) {
        Ok(PlaybackSummary { messages, failed, matched_topics, topics, interrupted }) => {
            let cut = if interrupted { ", interrupted" } else { "" };
            let failed = if failed > 0 { format!(", {failed} could not be sent") } else { String::new() };
            note!(
                "played {messages} messages on {topics} topics, {matched_topics} with subscribers at the start{failed}{cut}"
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            print_error("error", &error);
            ExitCode::from(2)
        }
    }
}
