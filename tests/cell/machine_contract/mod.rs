// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The check of machines against their contract (`nodes/MACHINE_CONTRACT.md`): the simulated machine keeps it, and the check reports
//! exactly the broken clause of a machine that breaks one.

mod go_between;
use crate::support;

use camwright_machine_check::{CheckError, Checked, ClauseVerdict, Moving, Settings, check};
use camwright_machine_sim::MachineSim;
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest};
use camwright_ros::{Node, NodeOptions, ParameterValue, Qos, RosArgs, Shutdown};
use go_between::{Fault, GoBetween};
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;
use support::{Domain, PATIENCE};

/// A cycle that leaves a busy computer time, a delay that is as long as usual, and an axis that settles at once.
const CALM: &[&str] = &["cycle_time_us=4000", "servo_steps_per_tick=16", "feedback_delay_ticks=60"];

fn args(domain: &Domain, namespace: &str) -> RosArgs {
    RosArgs::default().with_domain_id(domain.id()).with_namespace(namespace)
}

fn machine(domain: &Domain, namespace: &str, name: &str, pace: &str, more: &[&str]) -> MachineSim {
    started(domain, namespace, (name, pace), more, 50.0)
}

/// A machine with this rate of joint states at rest (Hz).
fn started(domain: &Domain, namespace: &str, (name, pace): (&str, &str), more: &[&str], rest_rate: f64) -> MachineSim {
    let text = |text: &str| ParameterValue::String(text.into());
    let overrides = CALM.iter().chain(more).map(ToString::to_string).collect();
    let args = args(domain, namespace)
        .with_parameter(Some("machine_sim"), "machine", text(name))
        .with_parameter(Some("machine_sim"), "pace", text(pace))
        .with_parameter(Some("machine_sim"), "state_file", text("none"))
        .with_parameter(Some("machine_sim"), "rest_publish_rate_hz", ParameterValue::Double(rest_rate))
        .with_parameter(Some("machine_sim"), "machine_overrides", ParameterValue::StringArray(overrides));
    MachineSim::start(&args).expect("machine_sim")
}

fn settings(moving: Option<(&str, f64)>) -> Settings {
    let moving = moving.map(|(joint, distance)| Moving { joint: joint.into(), distance });
    Settings { listen: Duration::from_secs(2), patience: PATIENCE, moving }
}

fn checked(domain: &Domain, namespace: &str, moving: Option<(&str, f64)>) -> Checked {
    check(&args(domain, namespace), &settings(moving), &Shutdown::new(), &|_| {}).expect("a machine that is free")
}

/// Clauses judged on a moving machine, at pace fast and in addition at pace realtime.
const MOVED: [u8; 16] = [1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 13, 14, 20, 30, 33, 41];
const MOVED_IN_TIME: [u8; 19] = [1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 20, 21, 30, 31, 33, 40];

/// Attempts at pace realtime: a virtual computer pauses for up to half a second, which is a late setpoint for every machine.
const ATTEMPTS: u32 = 3;

/// Returns the first report with exactly these broken clauses, or the last report of all attempts.
#[allow(clippy::print_stdout, reason = "for the reader of a failed test")]
fn best_of(pace: &str, broken: &[u8], attempt: impl Fn() -> Checked) -> Checked {
    let attempts = if pace == "realtime" { ATTEMPTS } else { 1 };
    let mut checked = attempt();
    for _ in 1..attempts {
        if checked.report.clauses(ClauseVerdict::Broken) == broken {
            break;
        }
        println!("once more, after:\n{}\n", checked.report);
        checked = attempt();
    }
    checked
}

#[test]
fn a_machine_at_rest_reports_every_fifth_period() {
    let domain = Domain::reserve();
    let node = Node::new(NodeOptions::new("listener", &args(&domain, "/idle"))).expect("a node");
    let received = Arc::new((Mutex::new(Vec::new()), Condvar::new()));
    let sink = Arc::clone(&received);
    let subscription = node.subscribe::<MachineStream>("machine/stream", &Qos::default_topic(), move |message, _| {
        sink.0.lock().expect("not poisoned").push(message.tick);
        sink.1.notify_all();
    });
    let subscription = subscription.expect("a subscription");
    let spin = node.spin_in_thread().expect("a thread");
    let machine = machine(&domain, "/idle", "cam_grinder", "realtime", &[]);
    let ticks = received.0.lock().expect("not poisoned");
    let (ticks, limit) =
        received.1.wait_timeout_while(ticks, PATIENCE, |ticks| ticks.len() < 30).expect("not poisoned");
    assert!(!limit.timed_out(), "{} messages", ticks.len());
    // A tenth of the delay of 60 ticks, five times; the first messages announce the machine.
    let gaps: Vec<u64> = ticks[9..].windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(gaps.iter().all(|gap| *gap == 30), "{gaps:?}");
    drop(ticks);
    machine.stop();
    drop((spin, subscription));
}

#[test]
fn the_simulated_machine_keeps_its_contract() {
    let cases = [
        ("cam_grinder", "realtime", "c_axis", 0.2, &MOVED_IN_TIME[..]),
        ("cam_grinder_with_dresser", "fast", "z_axis", 0.1, &MOVED[..]),
        ("cam_grinder_two_wheels", "fast", "z_axis", 0.1, &MOVED[..]),
        ("lathe", "fast", "c_axis", 7.0, &MOVED[..]),
    ];
    std::thread::scope(|scope| {
        for (name, pace, joint, distance, wanted) in cases {
            scope.spawn(move || {
                // Before the origin detector, so that there is a closed input to ask for.
                let more: &[&str] = if pace == "realtime" { &["c_axis.power_up_position_deg=0"] } else { &[] };
                let Checked { report, interrupted } = best_of(pace, &[], || {
                    let domain = Domain::reserve();
                    let machine = machine(&domain, "/cell", name, pace, more);
                    let checked = checked(&domain, "/cell", Some((joint, distance)));
                    machine.stop();
                    checked
                });
                println!("{name} at pace {pace}, {joint}\n{report}\n");
                assert!(!interrupted);
                assert_eq!(report.clauses(ClauseVerdict::Broken), Vec::<u8>::new(), "{name} at pace {pace}:\n{report}");
                for clause in wanted {
                    assert_eq!(
                        report.verdict(*clause),
                        ClauseVerdict::Kept,
                        "M{clause} of {name} at pace {pace}:\n{report}"
                    );
                }
            });
        }
    });
}

/// Faults of which each breaks one clause, behind one machine.
fn each_is_reported(faults: &[(Fault, u8)], pace: &str, moving: Option<(&str, f64)>, at_once: usize) {
    for some in faults.chunks(at_once) {
        std::thread::scope(|scope| {
            for (fault, clause) in some {
                scope.spawn(move || {
                    let Checked { report, .. } = best_of(pace, &[*clause], || {
                        let domain = Domain::reserve();
                        // One message a tick at rest too, of which one that is missing is seen.
                        let machine = started(&domain, "/sound", ("cam_grinder", pace), &[], 10_000.0);
                        if *fault == Fault::NoRemedy {
                            press(&machine, true);
                        }
                        let between = GoBetween::start(&domain, *fault);
                        let checked = checked(&domain, "/broken", moving);
                        between.stop();
                        machine.stop();
                        checked
                    });
                    assert_eq!(
                        report.clauses(ClauseVerdict::Broken),
                        [*clause],
                        "{fault:?} breaks M{clause}:\n{report}"
                    );
                });
            }
        });
    }
}

/// The emergency stop of a machine.
fn press(machine: &MachineSim, pressed: bool) {
    let client = machine.node().client::<SetBool>("machine/estop").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service");
    assert!(client.call(&SetBoolRequest { data: pressed }, PATIENCE).expect("an answer").success);
}

#[test]
fn each_wrong_message_is_reported_by_its_clause_alone() {
    let faults = [
        (Fault::None, 0),
        (Fault::OtherHash, 1),
        (Fault::OtherLimit, 1),
        (Fault::TickLeftOut, 2),
        (Fault::CreditBeyond, 4),
        (Fault::StampOff, 2),
        (Fault::StreamTooRare, 3),
        (Fault::CreditTooLarge, 4),
        (Fault::AxesSwapped, 5),
        (Fault::JointsUneven, 7),
        (Fault::JointStampOff, 7),
        (Fault::MovesAtStandstill, 8),
        (Fault::NotAtItsSetpoint, 8),
        (Fault::JointsBestEffort, 9),
        (Fault::NoRemedy, 30),
        (Fault::UnknownPace, 40),
    ];
    let (none, faults) = faults.split_first().expect("some");
    // The go-between alone breaks nothing.
    let domain = Domain::reserve();
    let machine = machine(&domain, "/sound", "cam_grinder", "realtime", &[]);
    let between = GoBetween::start(&domain, none.0);
    let Checked { report, .. } = checked(&domain, "/broken", None);
    assert_eq!(report.clauses(ClauseVerdict::Broken), Vec::<u8>::new(), "{report}");
    between.stop();
    machine.stop();
    each_is_reported(faults, "realtime", None, 7);
}

#[test]
fn each_wrong_behaviour_is_reported_by_its_clause_alone() {
    let faults = [
        (Fault::EdgeReportedTwice, 6),
        (Fault::EdgeElsewhere, 6),
        (Fault::OneCountOff, 10),
        (Fault::LossNotReported, 11),
        (Fault::RefusalNotReported, 13),
        (Fault::StrangerNotReported, 14),
        (Fault::GapNotReported, 20),
        (Fault::ResetWhileMoving, 30),
        (Fault::StopWithoutEffect, 33),
    ];
    // More than a turn, so that the origin detector sees its mark.
    each_is_reported(&faults, "fast", Some(("c_axis", 7.0)), 5);
    each_is_reported(&[(Fault::SilenceNotReported, 12)], "realtime", Some(("c_axis", 0.2)), 1);
}

#[test]
fn nothing_is_moved_where_it_is_not_free() {
    let domain = Domain::reserve();
    let machine = machine(&domain, "/cell", "cam_grinder", "fast", &[]);
    let run = |moving| check(&args(&domain, "/cell"), &settings(Some(moving)), &Shutdown::new(), &|_| {});
    let refusal = |moving| match run(moving) {
        Err(CheckError::Refused(why)) => why,
        other => panic!("{moving:?} is not refused: {other:?}"),
    };
    let beyond = refusal(("z_axis", 0.7));
    assert!(beyond.contains("z_axis would be at 0.7 m, its soft limits are -0.02 to 0.6 m"), "{beyond}");
    press(&machine, true);
    let operator = Node::new(NodeOptions::new("operator", &args(&domain, "/cell"))).expect("a node");
    let alarm = refusal(("z_axis", 0.002));
    assert!(alarm.contains("alarm 1 is active: emergency stop pressed"), "{alarm}");
    operator.shutdown();
    machine.stop();
}

#[test]
fn the_exit_code_gives_the_result() {
    let domain = Domain::reserve();
    let run = |more: &[&str]| {
        let mut command: Command = support::processes::in_domain(env!("CARGO_BIN_EXE_camwright"), &domain);
        let output = command.arg("check-machine").args(more).output().expect("camwright runs");
        let text = |octets: &[u8]| String::from_utf8_lossy(octets).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let (code, out, error) = run(&["--patience", "0.5"]);
    assert_eq!((code, out.as_str()), (Some(3), ""), "{error}");
    assert!(error.contains("no machine found within 0.5 s"), "{error}");
    let machine = machine(&domain, "/cell", "lathe", "fast", &[]);
    let (code, out, error) = run(&["--namespace", "/cell", "--seconds", "1", "--json"]);
    assert_eq!(code, Some(0), "{out}{error}");
    let report: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((&report["machine"], &report["broken"]), (&"lathe".into(), &0.into()), "{out}");
    assert_eq!(report["clauses"][1]["clause"], "M2");
    let (code, _, error) = run(&["--namespace", "/cell", "--move", "x_axis", "--distance", "1000"]);
    assert_eq!(code, Some(4), "{error}");
    assert!(error.contains("nothing is moved: x_axis would be at"), "{error}");
    machine.stop();
}
