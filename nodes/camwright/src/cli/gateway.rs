// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright gateway`: serves a running cell to MTConnect agents and OPC UA clients.

use super::machine_text::print_machine_text;
use super::output::{note, print_error};
use camwright_plant_gateway::{DEFAULT_ADDRESS, Nameplate, PlantGateway, UaOptions, devices};
use camwright_ros::running::NodeError;
use camwright_ros::{RosArgs, RosLayer, Shutdown};
use camwright_threads::system_time::system_time_ns;
use clap::Args;
use std::net::{IpAddr, SocketAddr};
use std::process::ExitCode;

/// Arguments of `camwright gateway`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::GATEWAY)]
pub(super) struct GatewayArgs {
    /// Port of the MTConnect adapter; 0 selects a free port.
    #[arg(long, value_name = "PORT", default_value_t = DEFAULT_ADDRESS.port(), value_parser = super::page::port)]
    mtconnect_port: u16,
    /// Address to serve at; 0.0.0.0 shows the cell to the whole network, without password and encryption.
    #[arg(long, value_name = "ADDRESS", default_value_t = DEFAULT_ADDRESS.ip())]
    bind: IpAddr,
    /// Serve OPC UA clients too; without PORT at 4840, 0 selects a free port.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "4840", value_parser = super::page::port)]
    opcua: Option<u16>,
    /// Maker of the machine, for OPC UA.
    #[arg(long, value_name = "NAME", requires = "opcua")]
    manufacturer: Option<String>,
    /// Serial number of the machine, for OPC UA.
    #[arg(long, value_name = "NUMBER", requires = "opcua")]
    serial_number: Option<String>,
    /// Globally unique URI of the machine, for OPC UA.
    #[arg(long, value_name = "URI", requires = "opcua")]
    product_instance_uri: Option<String>,
    /// Print the device model (`Devices.xml`) of a machine for the agent, and exit.
    #[arg(long, value_name = "MACHINE", conflicts_with_all = ["mtconnect_port", "bind", "opcua"])]
    devices: Option<String>,
    /// Namespace of the cell in the device model.
    #[arg(long, default_value = "/", requires = "devices", value_parser = namespace)]
    namespace: String,
    /// Set a key of the machine in the device model; repeatable.
    #[arg(long = "set-machine", value_name = "KEY=VALUE", requires = "devices")]
    set_machine: Vec<String>,
}

fn namespace(text: &str) -> Result<String, String> {
    let is_word = |word: &str| {
        word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let inner = text.strip_prefix('/').ok_or_else(|| format!("{text:?} does not begin with /, for example /cell_2"))?;
    if inner.is_empty() || inner.split('/').all(is_word) {
        return Ok(text.to_owned());
    }
    Err(format!("{text:?} is not a namespace of letters, digits and _, for example /cell_2"))
}

/// Entry point.
pub(super) fn main(args: &GatewayArgs, ros_args: &RosArgs) -> ExitCode {
    if let Some(machine) = &args.devices {
        return print_machine_text("camwright gateway", (machine, &args.set_machine), |file| {
            Ok(devices::document(&file.description, &args.namespace, system_time_ns()))
        });
    }
    RosLayer::install();
    match serve(args, ros_args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print_error("camwright gateway", &error);
            ExitCode::from(1)
        }
    }
}

fn serve(args: &GatewayArgs, ros_args: &RosArgs) -> Result<(), NodeError> {
    let shutdown = Shutdown::on_signals()?;
    let nameplate = Nameplate {
        manufacturer: args.manufacturer.clone(),
        serial_number: args.serial_number.clone(),
        product_instance_uri: args.product_instance_uri.clone(),
    };
    let ua = args.opcua.map(|port| UaOptions { address: SocketAddr::new(args.bind, port), nameplate });
    let gateway = PlantGateway::start(ros_args, SocketAddr::new(args.bind, args.mtconnect_port), ua.as_ref())?;
    note!("MTConnect adapter: {}", gateway.address());
    if let Some(address) = gateway.ua_address() {
        note!("OPC UA server: opc.tcp://{address}");
    }
    shutdown.wait();
    gateway.stop();
    Ok(())
}
