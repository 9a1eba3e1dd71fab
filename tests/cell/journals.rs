// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Journals that run out, ground by the whole cell: measured, decided, corrected in a second plan, and recorded; and the stiffness that was
//! measured on them, kept for the machine.

use crate::cell;
use crate::support;

use byteorder::LittleEndian;
use camwright_analysis::rerun::rerun;
use camwright_bag::Bag;
use camwright_files::stiffness_file::StoredStiffness;
use camwright_msgs::camwright_msgs::msg::{JobStatus, PartLobe, PlanPage};
use camwright_msgs::camwright_msgs::srv::{
    GetStiffness, GetStiffnessRequest, IdentifyStiffness, IdentifyStiffnessRequest, IdentifyStiffnessResponse,
};
use camwright_ros::{GoalStatus, ParameterValue};
use cell::{Cell, PATIENCE};
use std::process::Command;
use std::sync::mpsc;
use support::{Domain, Folder};

const TWO: &str = "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0, width_mm: 20}, \
     {name: J2, station: LS2, profile: journal, phase_deg: 40, width_mm: 20}]";

/// 12 um of finishing at 130 N, by the contact that is measured on each journal.
const BY_FORCE: &str = "runout_correction.finishing={stock_um: 12, force_n: 130}";

/// Output of a run of two parts with two of the shipped journals: its report, the finished part, and the halves of its plans in the bag.
fn ground(folder: &Folder, name: &str) -> (serde_json::Value, Vec<PartLobe>, Vec<u8>) {
    let (domain, bag) = (Domain::reserve(), folder.join(name));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join(&format!("{name}-state")));
    command.args(["run", "journal_runout", "--json", "--parts", "2", "--set", TWO, "--set", BY_FORCE, "--bag"]);
    let output = command.arg(&bag).output();
    let output = output.expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (mut part, mut halves) = (Vec::new(), Vec::new());
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical() && verdict.motions > 1, "{}", verdict.to_text());
    let html = camwright_analysis::report::html(&bag).expect("a report");
    let again = [
        "lobe J2: 4 finishing turns of at most 3.20 um",
        "Decided again from the recorded readings: the same second plan",
    ];
    assert!(again.iter().all(|words| html.contains(words)), "{again:?} are not all in the report");
    let bag = Bag::open(&bag).expect("a bag");
    let mut messages = bag.messages();
    while let Some(message) = messages.next_message().expect("a readable bag") {
        // Four octets say how the rest is encoded.
        let data = &message.data[4..];
        match bag.topics()[message.topic].name.as_str() {
            "/machine/part" => {
                let lobe: PartLobe = cdr_encoding::from_bytes::<_, LittleEndian>(data).expect("a part").0;
                part.extend(Some(lobe).filter(|lobe| lobe.finished));
            }
            "/job_planner/plan" => {
                let page: PlanPage = cdr_encoding::from_bytes::<_, LittleEndian>(data).expect("a page").0;
                halves.extend(page.header.iter().map(|header| header.half));
            }
            _ => {}
        }
    }
    (serde_json::from_slice(&output.stdout).expect("a report"), part, halves)
}

/// Two parts with two of the shipped journals over DDS, finished by force: rounder than a micrometre and a half, to size, with their plans in
/// the bag. The report decides the second plan again from the readings. Done once more, by nodes whose messages came at other times, both
/// parts are the same bit for bit.
#[test]
fn journals_are_measured_and_corrected_over_dds_the_same_every_time() {
    let folder = Folder::new("journals");
    let (report, part, halves) = ground(&folder, "one");
    for lobe in report["lobes"].as_array().expect("lobes") {
        let um = |key: &str| lobe[key].as_f64().expect("a number");
        assert!(um("runout_before_um") > 5.0 && um("runout_um") < 1.5, "{lobe}");
        assert!(um("form_error_max_um").abs() < 3.0, "{lobe}");
        assert!(um("spark_out_turns") > 5.0, "{lobe}");
    }
    assert_eq!(halves, [1, 2, 1, 2], "a first half and a second of both parts");
    let kept = folder.join("one-state/camwright/learned/journal_grinder.stiffness.yaml");
    let kept = StoredStiffness::parse(&kept, &std::fs::read_to_string(&kept).expect("a file")).expect("a stiffness");
    assert_eq!((kept.parts, kept.places().len()), (2, 2), "what was measured is kept");
    assert_eq!(part.iter().map(|lobe| lobe.name.as_str()).collect::<Vec<_>>(), ["J1", "J2", "J1", "J2"]);
    let (report_again, again, _) = ground(&folder, "two");
    assert_eq!(report["batch"]["parts"], report_again["batch"]["parts"], "plans and results of both parts");
    assert_eq!(part.len(), again.len());
    for (lobe, again) in part.iter().zip(&again) {
        let bits = |lobe: &PartLobe| lobe.radius.iter().map(|radius| radius.to_bits()).collect::<Vec<u64>>();
        assert!(bits(lobe) == bits(again), "lobe {}", lobe.name);
    }
}

const ONE: &str = "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0, width_mm: 20}]";

/// A measuring job grinds a journal, answers at its end and stores the result; a second one, and an unsuitable job, are refused at once. The
/// stored values correct the next part, and its recorded job contains them.
#[test]
fn stiffness_is_measured_by_a_service_kept_and_used() {
    let folder = Folder::new("stiffness");
    let text = |text: &str| ParameterValue::String(text.into());
    let cell = Cell::start_with(&[], |args| {
        args.with_parameter(Some("machine_sim"), "machine", text("journal_grinder")).with_parameter(
            Some("job_planner"),
            "learned_dir",
            text(&folder.path().display().to_string()),
        )
    });
    let wanted = |job: &str, set: &[&str]| IdentifyStiffnessRequest {
        job: job.into(),
        overrides: set.iter().map(ToString::to_string).collect(),
        forget: false,
    };
    let ask = |request| cell.client.call::<IdentifyStiffness>("job_planner/identify_stiffness", &request);
    let cannot = ask(wanted("eccentric", &["machine=journal_grinder", "wheel_radius_mm=60.0"]));
    assert!(!cannot.success && cannot.message.contains("is not round"), "{}", cannot.message);
    assert!(!cell.client.has_moved());
    let client = cell.client.node.client::<IdentifyStiffness>("job_planner/identify_stiffness").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service");
    let (sender, answers) = mpsc::channel::<IdentifyStiffnessResponse>();
    let answer = move |response| drop(sender.send(response));
    client.call_with(&wanted("journal_runout", &[ONE]), answer).expect("a request");
    cell.client.status("executes", |status| status.state == JobStatus::EXECUTING);
    let busy = ask(wanted("journal_runout", &[ONE]));
    assert!(!busy.success && busy.message.contains("is running; nothing moved"), "{}", busy.message);
    let answer = answers.recv_timeout(PATIENCE).expect("an answer");
    assert!(answer.success, "{}", answer.message);
    let [journal] = answer.journals.as_slice() else { panic!("{:?}", answer.journals) };
    let (km, kg) = (journal.machine_stiffness / 6.0e6, journal.grinding_stiffness / 3.0e7);
    assert!((km - 1.0).abs() < 0.05 && (kg - 1.0).abs() < 0.1 && (journal.z - 0.08).abs() < 1e-12, "{journal:?}");
    let kept = cell.client.call::<GetStiffness>("job_planner/get_stiffness", &GetStiffnessRequest::default());
    assert!(kept.success && kept.journals.len() == 1, "{}", kept.message);
    let differ = (kept.journals[0].ratio - journal.ratio).abs();
    assert!(differ < 1e-6, "{differ}");
    let (goal, _) =
        cell.client.send("journal_runout", &[ONE, "identification=null", "runout_correction.stiffness=kept"]);
    assert!(goal.accepted());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.lobes[0].runout < 1.5e-6 && result.lobes[0].runout_before > 3e-6, "{:?}", result.lobes);
    cell.client.status("is complete, with what is kept in its job", |status| {
        status.state == JobStatus::COMPLETE && status.job_source.contains("machine_n_um:")
    });
    cell.stop();
}
