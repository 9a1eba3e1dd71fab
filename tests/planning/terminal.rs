// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Results on a terminal: 80 columns, verdict on the first line, and the log lines of the nodes only with `-v`.

use crate::support;

use std::path::Path;
use std::process::{Command, Output};
use support::{Domain, Folder};

/// A four-lobe job with little to remove.
const SHORT: [&str; 4] = ["--set", "infeed.total_mm=0.072", "--set", "stock_mm=0.06"];

/// Runs camwright in a folder, so that its paths are short.
fn camwright(folder: &Folder, domain: &Domain, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(folder.path()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(words).output().expect("camwright runs")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Checks exit code, verdict and width of a result.
fn fits(output: &Output, code: i32, verdict: &str) {
    let (text, errors) = (stdout(output), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{text}{errors}");
    assert!(text.starts_with(verdict), "{verdict}: {text}");
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
}

#[test]
fn plan_check_and_post_print_the_verdict_first_in_80_columns() {
    let (folder, domain) = (Folder::new("terminal-plan"), Domain::reserve());
    let call = |words: &[&str]| camwright(&folder, &domain, words);
    for details in [&[][..], &["--details"]] {
        let with = |words: &[&'static str]| [words, details].concat();
        fits(&call(&with(&["plan", "four_lobe_camshaft", "--out", "plan"])), 0, "PLANNED: four_lobe_camshaft, 4 lobes");
        fits(&call(&with(&["plan", "turned_cam", "--out", "turned"])), 0, "PLANNED: turned_cam, 3 passes");
        fits(&call(&with(&["post", "four_lobe_camshaft", "--out", "nc"])), 0, "VERIFIED: largest path error ");
        fits(&call(&with(&["check", "four_lobe_camshaft"])), 0, "CLEAN: four_lobe_camshaft: 4 lobes");
        fits(&call(&with(&["check", "turned_cam"])), 0, "CLEAN: turned_cam: 3 passes");
    }
    let one_turn = ["check", "four_lobe_camshaft", "--set", "infeed.spark_out_turns=1"];
    fits(&call(&one_turn), 1, "WARNINGS: 1 warning");
    fits(&call(&["check", "four_lobe_camshaft", "--set", "work_speed_rpm=200"]), 2, "REFUSED: 4 errors");
}

#[test]
fn a_run_and_its_bag_print_the_verdict_first_in_80_columns_without_log_lines() {
    let (folder, domain) = (Folder::new("terminal-run"), Domain::reserve());
    let call = |words: &[&str]| camwright(&folder, &domain, words);
    let run = |bag: &'static str, more: &[&'static str]| {
        call(&[&["run", "four_lobe_camshaft", "--bag", bag], &SHORT[..], more].concat())
    };
    let quiet = run("quiet", &[]);
    fits(&quiet, 0, "GOOD: worst form error ");
    let text = stdout(&quiet);
    for lobe in ["\nI1 ", "\nE1 ", "\nI2 ", "\nE2 ", "\nbag:    quiet\n", "\nreport: quiet/report.html\n"] {
        assert_eq!(text.matches(lobe).count(), 1, "{lobe:?}: {text}");
    }
    assert!(text.lines().count() <= 12 && !text.contains("simulated without"), "{text}");
    assert_eq!(String::from_utf8_lossy(&quiet.stderr), "", "no log lines");

    let loud = run("loud", &["-v", "--details", "--causes", "--timings"]);
    fits(&loud, 0, "GOOD: worst form error ");
    let log = String::from_utf8_lossy(&loud.stderr).into_owned();
    let stages = ["planning   ", "starting the nodes   ", "running the job   ", "writing the report   ", "in all   "];
    for words in ["[job_planner]: ", "[axis_interpolator]: ", "[run_logger]: "].into_iter().chain(stages) {
        assert!(log.contains(words), "{words}: {log}");
    }
    for words in ["form error max in um (rms, lift p-v)", "burn index (burnt above 1)", "computing time"] {
        assert!(stdout(&loud).contains(words), "{words}");
    }
    assert!(!stdout(&loud).contains("[INFO]"), "log lines are on stderr");

    fits(&call(&["replay", "quiet", "--against"]), 0, "identical: ");
    fits(&call(&["bag", "check", "quiet"]), 0, "CLEAN: ");
    fits(&call(&["bag", "info", "quiet"]), 0, "COMPLETE: ");
    fits(&call(&["bag", "recover", "quiet"]), 0, "NOTHING LOST: ");
    fits(&call(&["replan", "quiet"]), 0, "SAME: 1 jobs of 1 bags");

    const LESS: [&str; 2] = ["--set", "infeed.spark_out_turns=2"];
    let bad = run("bad", &LESS);
    let text = stdout(&bad);
    fits(&bad, 4, "NOT GOOD: worst form error ");
    assert!(text.contains("\nnext:   open the report") && text.contains("--causes"), "{text}");
    // The zone that uses most of its tolerance decides, not the largest error.
    let zones = run("zones", &["--set", "form_tolerance.all_um=20", "--set", "form_tolerance.base_um=0.1"]);
    fits(&zones, 4, "NOT GOOD: worst form error ");
    assert!(stdout(&zones).contains(" deg (tolerance 0.1 um)\n"), "{}", stdout(&zones));
    let page = std::fs::read_to_string(folder.join("zones/report.html")).expect("a report");
    assert!(page.contains("4 of 4 lobes") || page.contains("All 4 lobes are out of tolerance"), "the report judges");
    assert!(page.contains("shaded: ±0.1 to 20.0 µm"), "the field of the tolerance follows the zones");
    let text = stdout(&run("why", &[&LESS[..], &["--causes"]].concat()));
    assert!(text.contains("\ncause:  ") && text.contains("simulated without:"), "{text}");
}

/// Runs camwright on a terminal of its own; everything that the terminal shows.
fn on_terminal(folder: &Folder, domain: &Domain, words: &str) -> String {
    let line = format!("stty cols 80; '{}' {words}", env!("CARGO_BIN_EXE_camwright"));
    let mut command = Command::new("script");
    command.args(["-qefc", &line, "/dev/null"]).current_dir(folder.path()).stdin(std::process::Stdio::null());
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_STATE_HOME", folder.path());
    command.env("TERM", "xterm").env_remove("NO_COLOR").env_remove("CLICOLOR").env_remove("CLICOLOR_FORCE");
    let output = command.output().expect("script is part of util-linux");
    assert!(output.status.success(), "{}", stdout(&output));
    stdout(&output)
}

#[test]
fn verdicts_are_coloured_on_a_terminal_or_as_asked() {
    const GREEN: &str = "\u{1b}[1m\u{1b}[32mCLEAN\u{1b}[0m: ";
    const RED: &str = "\u{1b}[1m\u{1b}[31merror\u{1b}[0m: ";
    let (folder, domain) = (Folder::new("terminal-colour"), Domain::reserve());
    let check = |color: &str, no_color: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.current_dir(folder.path()).env("NO_COLOR", no_color).args([
            "check",
            "four_lobe_camshaft",
            "--color",
            color,
        ]);
        stdout(&command.output().expect("camwright runs"))
    };
    assert!(check("auto", "").starts_with("CLEAN: ") && check("never", "").starts_with("CLEAN: "), "a pipe");
    assert!(check("always", "1").starts_with(GREEN), "the argument wins");
    assert!(on_terminal(&folder, &domain, "check four_lobe_camshaft").contains(GREEN));
    let plain = on_terminal(&folder, &domain, "--color never check four_lobe_camshaft");
    assert!(plain.contains("CLEAN: ") && !plain.contains('\u{1b}'), "{plain:?}");
    let refused = camwright(&folder, &domain, &["check", "nowhere", "--color=always"]);
    assert!(String::from_utf8_lossy(&refused.stderr).starts_with(RED), "{refused:?}");
}

#[test]
fn quiet_prints_errors_only() {
    let (folder, domain) = (Folder::new("terminal-silence"), Domain::reserve());
    let call = |words: &[&str]| camwright(&folder, &domain, words);
    for words in [&["--quiet", "check", "four_lobe_camshaft"][..], &["plan", "eccentric", "--out", "plan", "-q"]] {
        let output = call(words);
        assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty(), "{output:?}");
    }
    let warned = call(&["-q", "check", "four_lobe_camshaft", "--set", "infeed.spark_out_turns=1"]);
    assert!(warned.status.code() == Some(1) && warned.stdout.is_empty() && warned.stderr.is_empty(), "{warned:?}");
    let refused = call(&["-q", "check", "nowhere"]);
    assert!(refused.stdout.is_empty() && refused.stderr.starts_with(b"error: "), "{refused:?}");
}

/// One bar from the plan to the report, which ends full; without a terminal there is none.
#[test]
fn the_bar_of_a_run_ends_at_100_percent() {
    let (folder, domain) = (Folder::new("terminal-bar"), Domain::reserve());
    let job = format!("run four_lobe_camshaft --bag run {}", SHORT.join(" "));
    let shown = on_terminal(&folder, &domain, &job);
    let percent: Vec<u32> =
        (shown.split('\r')).filter_map(|line| line.split(" %  ").next()?.rsplit(' ').next()?.parse().ok()).collect();
    assert_eq!((percent.first(), percent.last()), (Some(&0), Some(&100)), "{shown}");
    assert!(percent.is_sorted(), "{percent:?}");
    let verdict = shown.find("GOOD").expect("a verdict");
    assert!(shown.find("100 %").is_some_and(|end| end < verdict), "{shown}");
    assert!(camwright(&folder, &domain, &["replan", "run", "-q"]).stderr.is_empty());
}

/// Every `--json` is one value and nothing else.
#[test]
fn results_for_scripts_are_json_alone() {
    let (folder, domain) = (Folder::new("terminal-json"), Domain::reserve());
    let run = [&["run", "four_lobe_camshaft", "--bag", "run"][..], &SHORT].concat();
    for words in [
        &run[..],
        &["plan", "eccentric", "--out", "plan"],
        &["post", "eccentric_disc", "--out", "nc"],
        &["check", "four_lobe_camshaft"],
        &["list", "alarms"],
        &["bag", "info", "run"],
        &["bag", "check", "run"],
        &["bag", "report", "run", "--out", "report.html"],
        &["bag", "export", "run"],
        &["bag", "recover", "run"],
        &["replay", "run", "--against"],
        &["replan", "run"],
    ] {
        let output = camwright(&folder, &domain, &[words, &["--json"]].concat());
        let text = stdout(&output);
        assert!(output.status.success(), "{words:?}: {text}{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_str::<serde_json::Value>(&text).unwrap_or_else(|error| panic!("{words:?}: {error}: {text}"));
    }
}

#[test]
fn every_command_has_a_man_page_and_every_shell_its_completions() {
    let (folder, domain) = (Folder::new("terminal-man"), Domain::reserve());
    fits(&camwright(&folder, &domain, &["man", "pages"]), 0, "written: ");
    let page = |name: &str| std::fs::read_to_string(folder.join(&format!("pages/{name}.1"))).expect("a page");
    for name in ["camwright", "camwright-run", "camwright-bag-info", "camwright-setup-touch-off"] {
        let text = page(name);
        for section in [".SH NAME", ".SH SYNOPSIS", ".SH EXAMPLES", ".SH \"EXIT STATUS\""] {
            assert!(text.contains(section), "{section} is not in the page of {name}: {text}");
        }
    }
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = camwright(&folder, &domain, &["completions", shell]);
        let text = stdout(&output);
        assert!(output.status.success() && text.contains("check-machine") && text.contains("against"), "{shell}");
    }
    folder.write("completions", &stdout(&camwright(&folder, &domain, &["completions", "bash"])));
    let words = "source ./completions; COMP_WORDS=(camwright bag in); COMP_CWORD=2; _camwright camwright in bag; echo ${COMPREPLY[@]}";
    let offered = Command::new("bash").args(["-c", words]).current_dir(folder.path()).output().expect("bash");
    assert_eq!(stdout(&offered).trim(), "info", "{offered:?}");
}

/// Names of the commands in a help.
fn commands(text: &str) -> Vec<String> {
    let lines = text.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = lines.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    names.map(str::to_owned).collect()
}

/// Every command's help fits 80 columns and ends with an example and the exit codes; examples that need no running cell work.
#[test]
fn help_fits_80_columns_and_its_examples_work() {
    let (folder, domain) = (Folder::new("terminal-help"), Domain::reserve());
    let mut examples = Vec::new();
    let mut help = |words: &[&str]| {
        let output = camwright(&folder, &domain, &[words, &["--help"]].concat());
        fits(&output, 0, "");
        let text = stdout(&output);
        let example = text.rfind("Example").unwrap_or_else(|| panic!("{words:?} has no example"));
        assert!(text[example..].contains("\nExit codes"), "{words:?}: {text}");
        let lines = text[example..].lines().map(|line| line.trim_start_matches("Example: ").trim());
        examples.extend(lines.filter(|line| line.starts_with("camwright ")).map(str::to_owned));
        text
    };
    let all = commands(&help(&[]));
    assert!(all.len() >= 14, "{all:?}");
    for command in &all {
        let text = help(&[command]);
        for inner in commands(&text) {
            help(&[command, &inner]);
        }
    }
    let offline =
        ["plan", "post", "init", "list", "check", "schema", "drives", "urdf", "bag", "replan", "completions", "man"];
    examples.retain(|example| example.split(' ').nth(1).is_some_and(|command| offline.contains(&command)));
    examples.sort();
    examples.dedup();
    assert!(examples.len() > 20, "{examples:?}");

    let home = folder.join("home");
    for made in ["home/.config/fish/completions", "home/.zfunc", "given"] {
        std::fs::create_dir_all(folder.join(made)).expect("our folder");
    }
    let given = folder.join("given");
    let binary = Path::new(env!("CARGO_BIN_EXE_camwright"));
    let path =
        format!("{}:{}", binary.parent().expect("a folder").display(), std::env::var("PATH").unwrap_or_default());
    let shell = |line: &str, within: &Path| {
        let mut command = Command::new("sh");
        command.args(["-c", line]).current_dir(within).env("HOME", &home).env("PATH", &path);
        command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_STATE_HOME", folder.path());
        let output = command.output().expect("sh");
        // Warnings and differences are answers too.
        let has = |command: &str, code| line.contains(command) && output.status.code() == Some(code);
        let is_answer = output.status.success() || has(" check ", 1) || has(" replan ", 3);
        assert!(is_answer, "{line}: {}{}", stdout(&output), String::from_utf8_lossy(&output.stderr));
    };
    shell("camwright init job && camwright init machine my_machine.yaml", &given);
    std::fs::copy(support::repository().join("params/nodes.yaml"), given.join("nodes.yaml")).expect("a copy");
    shell(&format!("camwright run four_lobe_camshaft --bag bags/my_run {}", SHORT.join(" ")), &given);
    for (number, example) in examples.iter().enumerate() {
        let name = format!("example-{number}");
        // An example writes its files beside those that it is given.
        let files = if example.starts_with("camwright init") { "" } else { "/." };
        let within = folder.join(&name);
        shell(&format!("mkdir {name} && if [ -n '{files}' ]; then cp -r given{files} {name}; fi"), folder.path());
        shell(example, &within);
    }
}
