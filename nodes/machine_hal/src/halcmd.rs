// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Comparison of a machine file with the HAL that runs, by the output of `halcmd`.

use crate::connection::{SAMPLER_COLUMNS, STREAMER_COLUMNS, functions, links, own_signals};
use camwright::machine::description::MachineDescription;
use camwright_files::hal_file::HalConfig;
use std::collections::BTreeMap;
use std::process::Command;

/// A pin that HAL has.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Pin {
    kind: String,
    direction: String,
    signal: Option<String>,
}

/// Pins by name, from the lines of `halcmd -s show pin`: owner, type, direction, value, name, and the signal behind an arrow.
fn pins(text: &str) -> BTreeMap<String, Pin> {
    let pin = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, kind, direction, _, name, rest @ ..] = words.as_slice() else { return None };
        let signal = (rest.len() == 2).then(|| rest[1].to_owned());
        Some(((*name).to_owned(), Pin { kind: (*kind).to_owned(), direction: (*direction).to_owned(), signal }))
    };
    text.lines().filter_map(pin).collect()
}

/// Period (ns) and functions of a thread, from the lines of `halcmd -s show thread`: period, floating point, name, two times, functions.
fn thread(text: &str, name: &str) -> Option<(u64, Vec<String>)> {
    text.lines().find_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [period, _, thread, _, _, functions @ ..] = words.as_slice() else { return None };
        let period = period.parse().ok().filter(|_| *thread == name)?;
        Some((period, functions.iter().map(|function| (*function).to_owned()).collect()))
    })
}

fn show(what: &str) -> Result<String, String> {
    let output = Command::new("halcmd")
        .args(["-s", "show", what])
        .output()
        .map_err(|error| format!("halcmd does not start: {error}; install the package linuxcnc-uspace"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        return Ok(text);
    }
    let reason = String::from_utf8_lossy(&output.stderr);
    Err(format!("halcmd reports: {}; start HAL as this user: halrun -I -f FILE.hal", reason.trim()))
}

/// Returns everything in which the running HAL does not fit the machine.
///
/// # Errors
/// HAL does not run.
pub(crate) fn compare(hal: &HalConfig, machine: &MachineDescription) -> Result<Vec<String>, String> {
    Ok(findings(hal, machine, &show("pin")?, &show("thread")?))
}

fn findings(hal: &HalConfig, machine: &MachineDescription, pin_text: &str, thread_text: &str) -> Vec<String> {
    let pins = pins(pin_text);
    let mut findings = Vec::new();
    if pins.is_empty() {
        return vec!["HAL runs without a pin; start it with a file: halrun -I -f FILE.hal".to_owned()];
    }
    match thread(thread_text, &hal.thread) {
        None => findings.push(format!("hal.thread: there is no thread {}", hal.thread)),
        Some((period_ns, executed)) => {
            if period_ns != u64::from(machine.cycle_time_ns) {
                findings.push(format!(
                    "hal.thread: the period of {} is {period_ns} ns; cycle_time_us needs {}",
                    hal.thread, machine.cycle_time_ns
                ));
            }
            for function in functions(hal).concat() {
                if !executed.contains(&function) {
                    findings.push(format!("hal.thread: {} does not execute {function}; addf is missing", hal.thread));
                }
            }
        }
    }
    for (component, columns) in [("streamer", STREAMER_COLUMNS), ("sampler", SAMPLER_COLUMNS)] {
        for (index, column) in columns.chars().enumerate() {
            let name = format!("{component}.0.pin.{index}");
            let kind = match column {
                'f' => "float",
                'b' => "bit",
                's' => "s32",
                _ => "u32",
            };
            match pins.get(&name) {
                Some(pin) if pin.kind == kind => {}
                Some(pin) => findings.push(format!("{name} is {}; cfg={columns} makes it {kind}", pin.kind)),
                None => findings.push(format!("{name} is missing; load {component} with cfg={columns}")),
            }
        }
    }
    for link in links(hal) {
        let (key, name) = (&link.key, &link.pin);
        let Some(pin) = pins.get(name) else {
            findings.push(format!("{key}: there is no pin {name}"));
            continue;
        };
        if pin.kind != link.kind.name() {
            findings.push(format!("{key}: {name} is {}; it must be {}", pin.kind, link.kind.name()));
        }
        if !link.direction.is_served_by(&pin.direction) {
            let (found, needed) = (&pin.direction, link.direction.name());
            findings.push(format!("{key}: the direction of {name} is {found}; it must be {needed}"));
            continue;
        }
        let ours = pins.get(&link.ours).and_then(|pin| pin.signal.as_ref());
        if ours.is_none() || pin.signal.as_ref() != ours {
            findings.push(format!("{key}: {name} is not on a signal with {}; net is missing", link.ours));
        }
    }
    for own in own_signals(hal) {
        let signal = |name: &str| pins.get(name).and_then(|pin| pin.signal.as_ref());
        let from = &own.from;
        for to in own.to.iter().filter(|to| signal(from).is_none() || signal(from) != signal(to)) {
            findings.push(format!("{from} is not on a signal with {to}; net is missing"));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hal_file_text::tests::grinder_with_index;

    /// Output of `halcmd -s` for a complete connection.
    fn shown(hal: &HalConfig) -> (String, String) {
        let mut lines = Vec::new();
        let signals: BTreeMap<String, String> = links(hal)
            .into_iter()
            .flat_map(|link| [(link.ours, link.signal.clone()), (link.pin.clone(), link.signal)])
            .chain(own_signals(hal).into_iter().flat_map(|own| {
                let pins = own.to.into_iter().chain([own.from]);
                pins.map(move |pin| (pin, own.signal.clone())).collect::<Vec<_>>()
            }))
            .collect();
        let mut add = |kind: &str, direction: &str, name: &str| {
            let arrow = signals.get(name).map_or_else(String::new, |signal| format!(" ==> {signal}"));
            lines.push(format!("8 {kind} {direction} 0 {name}{arrow}"));
        };
        for (component, columns, direction) in
            [("streamer", STREAMER_COLUMNS, "OUT"), ("sampler", SAMPLER_COLUMNS, "IN")]
        {
            for (index, column) in columns.chars().enumerate() {
                let kind = ["float", "bit", "s32", "u32"]["fbsu".find(column).expect("a kind")];
                add(kind, direction, &format!("{component}.0.pin.{index}"));
            }
        }
        let with_their_own = |name: &String| !name.starts_with("streamer.0.pin") && !name.starts_with("sampler");
        let own = own_signals(hal).into_iter().flat_map(|own| own.to.into_iter().chain([own.from]));
        for pin in own.filter(with_their_own).filter(|name| !name.starts_with("wsum")) {
            add("bit", "I/O", &pin);
        }
        for word in 0..2 {
            add("s32", "OUT", &format!("wsum.{word}.sum"));
            (0..16).for_each(|bit| add("bit", "IN", &format!("wsum.{word}.bit.{bit}.in")));
        }
        for link in links(hal) {
            add(link.kind.name(), link.direction.name(), &link.pin);
            if link.ours.ends_with("-on.out") {
                add(link.kind.name(), "OUT", &link.ours);
            }
        }
        let executed = functions(hal).map(|functions| functions.join(" ")).join(" x-drive ");
        (lines.join("\n"), format!("1000000 YES servo-thread 12 34 {executed}\n"))
    }

    #[test]
    fn a_hal_that_fits_has_no_finding_and_every_difference_has_one() {
        let (machine, hal) = grinder_with_index();
        let (pins, threads) = shown(&hal);
        assert_eq!(findings(&hal, &machine, &pins, &threads), Vec::<String>::new());
        // Each word that is changed, and what the finding has to name.
        for (is_thread, from, to, named) in [
            (
                false,
                "float IN 0 x-command.in0",
                "float IN 0 x-other",
                "hal.x_axis.command: there is no pin x-command.in0",
            ),
            (false, "float IN 0 x-command.in0", "s32 IN 0 x-command.in0", "x-command.in0 is s32; it must be float"),
            (false, "float IN 0 x-command.in0", "float OUT 0 x-command.in0", "direction of x-command.in0 is OUT"),
            (false, "x-command.in0 ==> camwright", "x-command.in0 ==> other", "not on a signal with streamer.0.pin.2"),
            (false, "float OUT 0 streamer.0.pin.2", "bit OUT 0 streamer.0.pin.2", "streamer.0.pin.2 is bit"),
            (false, "sampler.0.pin.6 ", "sampler.0.pin.9 ", "sampler.0.pin.6 is missing"),
            (
                false,
                "camwright-silence.q ==> camwright",
                "camwright-silence.q ==> other",
                "with camwright-wheel-on.in-1",
            ),
            (
                false,
                "bit I/O 0 x-index.index-enable",
                "bit OUT 0 x-index.index-enable",
                "direction of x-index.index-enable is OUT; it must be I/O",
            ),
            (
                false,
                "wsum.0.bit.13.in ==> camwright",
                "wsum.0.bit.13.in ==> other",
                "not on a signal with wsum.0.bit.13.in",
            ),
            (
                false,
                "float OUT 0 gauge-reading.out",
                "float OUT 0 other",
                "hal.gauge.reading: there is no pin gauge-reading.out",
            ),
            (
                false,
                "float OUT 0 gauge-reading.out",
                "s32 OUT 0 gauge-reading.out",
                "hal.gauge.reading: gauge-reading.out is s32; it must be float",
            ),
            (
                false,
                "float OUT 0 gauge-reading.out",
                "float IN 0 gauge-reading.out",
                "hal.gauge.reading: the direction of gauge-reading.out is IN; it must be OUT",
            ),
            (
                false,
                "gauge-reading.out ==> camwright",
                "gauge-reading.out ==> other",
                "gauge-reading.out is not on a signal with sampler.0.pin.11",
            ),
            (
                false,
                "bit OUT 0 gauge-valid.out",
                "float OUT 0 gauge-valid.out",
                "hal.gauge.valid: gauge-valid.out is float; it must be bit",
            ),
            (false, "bit OUT 0 gauge-valid.out", "bit OUT 0 other", "hal.gauge.valid: there is no pin gauge-valid.out"),
            (
                false,
                "wsum.0.bit.15.in ==> camwright",
                "wsum.0.bit.15.in ==> other",
                "gauge-valid.out is not on a signal with wsum.0.bit.15.in",
            ),
            (true, "camwright-x-axis-index", "other", "does not execute camwright-x-axis-index"),
            (true, "camwright-silence", "other", "does not execute camwright-silence"),
            (true, "1000000", "2000000", "period of servo-thread is 2000000 ns"),
            (true, "servo-thread", "other", "there is no thread servo-thread"),
            (true, "sampler.0", "other", "does not execute sampler.0"),
        ] {
            let changed = |text: &str, is_this: bool| if is_this { text.replace(from, to) } else { text.to_owned() };
            let (pins, threads) = (changed(&pins, !is_thread), changed(&threads, is_thread));
            let found = findings(&hal, &machine, &pins, &threads);
            assert!(found.iter().any(|finding| finding.contains(named)), "{from} -> {to}: {found:?}");
        }
        assert!(findings(&hal, &machine, "", "")[0].contains("without a pin"));
    }
}
