// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright page`: serves the operator page of a running cell.

use super::output::{note, print_error, whole_number};
use camwright_operator_page::{DEFAULT_ADDRESS, OperatorPage};
use camwright_ros::running::NodeError;
use camwright_ros::{RosArgs, RosLayer, Shutdown};
use clap::Args;
use std::net::{IpAddr, SocketAddr};
use std::process::ExitCode;

/// Arguments of `camwright page`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::PAGE)]
pub(super) struct PageArgs {
    /// Port; 0 selects a free port.
    #[arg(long, default_value_t = DEFAULT_ADDRESS.port(), value_parser = port)]
    port: u16,
    /// Address to serve at; 0.0.0.0 opens the page to the network.
    #[arg(long, value_name = "ADDRESS", default_value_t = DEFAULT_ADDRESS.ip())]
    bind: IpAddr,
    /// Let viewers operate the cell; the printed address contains the token.
    #[arg(long)]
    control: bool,
}

pub(super) fn port(text: &str) -> Result<u16, String> {
    whole_number(text, 0..=u16::MAX)
}

/// Entry point.
pub(super) fn main(args: &PageArgs, ros_args: &RosArgs) -> ExitCode {
    RosLayer::install();
    match serve(args, ros_args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print_error("camwright page", &error);
            ExitCode::from(1)
        }
    }
}

fn serve(args: &PageArgs, ros_args: &RosArgs) -> Result<(), NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let page = OperatorPage::start(ros_args, SocketAddr::new(args.bind, args.port), args.control)?;
    print_address(&page);
    shutdown.wait();
    page.stop();
    Ok(())
}

/// Prints the address of the page.
pub(super) fn print_address(page: &OperatorPage) {
    note!("operator page: {}", page.url());
}
