// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright schema`: JSON Schema of the files.

use super::output::say;
use camwright_files::file_kind::FileKind;
use camwright_files::schema;
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::process::ExitCode;

/// Arguments of `camwright schema`.
#[derive(Debug, Args)]
#[command(after_help = "An editor with a YAML language server completes and checks a file whose first line is\n  \
    # yaml-language-server: $schema=job.schema.json\n\nExample: camwright schema job > job.schema.json\n\nExit codes: 0 printed, 2 wrong \
    arguments")]
pub(super) struct SchemaArgs {
    /// Kind of file.
    #[arg(value_parser = PossibleValuesParser::new(FileKind::ALL.map(FileKind::name)))]
    kind: String,
    /// Print the keys as a Markdown table instead.
    #[arg(long)]
    table: bool,
}

/// Entry point.
pub(super) fn main(args: &SchemaArgs) -> ExitCode {
    let Some(kind) = FileKind::ALL.into_iter().find(|kind| kind.name() == args.kind) else {
        return ExitCode::from(2);
    };
    let schema = kind.schema();
    if args.table {
        say!("{}", schema::table(&schema).trim_end());
    } else {
        say!("{schema:#}");
    }
    ExitCode::SUCCESS
}
