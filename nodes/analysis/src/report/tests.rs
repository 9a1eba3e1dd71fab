// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The way from a bag to the page, on small bags made here.

use super::*;
use byteorder::LittleEndian;
use camwright_bag::qos::{Durability, Reliability};
use camwright_bag::{BagWriter, Preset, QosProfile, RecordingOutcome, Topic, WriterOptions};
use camwright_msgs::camwright_msgs::msg::{
    Alarm, JobStatus, LobeForm, LobeResult, MachineAlarms, PartLobe, TurnedResult,
};
use camwright_msgs::cdr::sample_from_message;
use serde::Serialize;
use tempfile::TempDir;

const HOSTILE: &str = "<script>alert('&')</script>";

fn write<T: Serialize>(writer: &mut BagWriter, name: &str, type_name: &str, at: u64, message: &T) {
    let mut data = vec![0, 1, 0, 0];
    data.extend(cdr_encoding::to_vec::<T, LittleEndian>(message).expect("it is a message"));
    write_data(writer, &topic(name, type_name), at, &data);
}

fn topic(name: &str, type_name: &str) -> Topic {
    let info = camwright_msgs::by_type_name(type_name).expect("the type is one of ours");
    Topic {
        name: name.into(),
        type_name: type_name.into(),
        type_hash: info.type_hash.into(),
        definition: info.schema.into(),
        offered_qos: vec![QosProfile::discovered(Reliability::Reliable, Durability::TransientLocal)],
    }
}

fn write_data(writer: &mut BagWriter, topic: &Topic, at: u64, data: &[u8]) {
    let id = writer.add_topic(topic).expect("it is open");
    let ns = 1_760_000_000_000_000_000 + at * 1_000_000;
    writer.write(id, ns, ns, data).expect("it is open");
}

/// A bag of some messages of the cell `/a/`.
fn bag(dir: &TempDir, messages: impl FnOnce(&mut BagWriter)) -> PathBuf {
    let path = dir.path().join("run");
    let options = WriterOptions { preset: Preset::Default, ..WriterOptions::default() };
    let mut writer = BagWriter::create(&path, &options).expect("the directory is free");
    messages(&mut writer);
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    path
}

fn status(state: u8) -> JobStatus {
    JobStatus { state, job: HOSTILE.into(), message: HOSTILE.into(), ..JobStatus::default() }
}

/// Text of a bag stays text, and missing data is reported: a job of which only an alarm is recorded.
#[test]
fn a_hostile_bag_gives_a_page_without_a_script_and_the_same_bag_the_same_bytes() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = bag(&dir, |writer| {
        let alarm = Alarm {
            tick: 7,
            number: 42,
            severity: Alarm::POWER_OFF,
            source: HOSTILE.into(),
            text: HOSTILE.into(),
            remedy: HOSTILE.into(),
            active: true,
            ..Alarm::default()
        };
        let alarms = MachineAlarms { tick: 7, alarms: vec![alarm], ..MachineAlarms::default() };
        let of_job = "camwright_msgs/msg/JobStatus";
        write(writer, "/a/job_planner/job_status", of_job, 1, &status(JobStatus::PLANNING));
        write(writer, "/a/machine/alarms", "camwright_msgs/msg/MachineAlarms", 2, &alarms);
        write(writer, "/a/job_planner/job_status", of_job, 3, &status(JobStatus::ABORTED));
        // Of the same name and another type: it is counted and omitted.
        write(writer, "/a/machine/part", "std_msgs/msg/String", 4, &String::from("no part"));
    });
    let page = html(&path).expect("a report");
    assert_eq!(page, html(&path).expect("the same report"));
    assert!(!page.contains("<script") && page.contains("&lt;script&gt;"), "{page}");
    assert!(page.contains("<h1>NOT COMPLETE</h1>") && page.contains("Alarm 42"), "{page}");
    for message in ["not recorded", "1 messages could not be understood", "the bag does not hold the job&#39;s file"] {
        assert!(page.contains(message), "{message}: {page}");
    }
    assert!(
        !page.contains("http://") && !page.contains("https://") && !page.contains("url("),
        "nothing from elsewhere"
    );
    let out = write_to_bag(&path);
    assert_eq!(fs::read_to_string(out).expect("it was written"), page);
}

fn write_to_bag(path: &Path) -> PathBuf {
    let out = super::write(path, None, None).expect("it is written");
    assert_eq!(out, path.join(FILE_NAME));
    out
}

/// A job of one lobe, A, that is 7.5 µm too small somewhere.
fn lobe_out_of_tolerance(writer: &mut BagWriter) {
    let mut form_error = vec![0.0; 720];
    form_error[100] = -7.5e-6;
    let form =
        LobeForm { name: "A".into(), tolerance: 5e-6, contour: vec![0.02; 720], form_error, ..LobeForm::default() };
    let lobe =
        LobeResult { name: "A".into(), form_error_max: -7.5e-6, form_error_max_angle: 0.5, ..LobeResult::default() };
    let done = JobStatus { lobes: vec![lobe], job: "a job".into(), ..status(JobStatus::COMPLETE) };
    let of_job = "camwright_msgs/msg/JobStatus";
    write(writer, "/job_planner/job_status", of_job, 1, &status(JobStatus::PLANNING));
    let plan = camwright_msgs::camwright_msgs::msg::PlanPage {
        plan_hash: "p".into(),
        page_count: 1,
        header: vec![camwright_msgs::camwright_msgs::msg::PlanHeader { lobes: vec!["A".into()], ..Default::default() }],
        ..Default::default()
    };
    write(writer, "/job_planner/plan", "camwright_msgs/msg/PlanPage", 2, &plan);
    write(writer, "/job_planner/lobe_forms", "camwright_msgs/msg/LobeForm", 3, &form);
    write(writer, "/job_planner/job_status", of_job, 4, &done);
}

/// The figure under a heading that begins so.
fn figure<'a>(page: &'a str, heading: &str) -> &'a str {
    let rest = page.split(&format!("<figcaption>{heading}")).nth(1).unwrap_or_else(|| panic!("{heading}: {page}"));
    rest.split("</figure>").next().unwrap_or_default()
}

/// The recorded values of every degree are drawn; an older bag without the force is read all the same, and the report says that it has
/// none.
#[test]
fn the_force_is_drawn_where_the_bag_has_it_and_missing_where_it_is_older() {
    const PART: &str = "camwright_msgs/msg/PartLobe";
    let part = |normal_force| PartLobe {
        name: "A".into(),
        finished: true,
        radius: vec![0.02; 720],
        power: vec![1000.0; 360],
        normal_force,
        ..PartLobe::default()
    };
    let dir = TempDir::new().expect("a temporary directory");
    let page = html(&bag(&dir, |writer| {
        lobe_out_of_tolerance(writer);
        write(writer, "/machine/part", PART, 5, &part(vec![40.0; 360]));
    }));
    let page = page.expect("a report");
    assert!(figure(&page, "Normal force of the wheel on lobe A (N)").contains("<path class=\"is\""), "{page}");
    let dir = TempDir::new().expect("a temporary directory");
    let page = html(&bag(&dir, |writer| {
        let mut former = topic("/machine/part", PART);
        former.definition = former
            .definition
            .lines()
            .filter(|line| !line.contains("[] normal_force ") && !line.contains("[] centre "))
            .fold(String::new(), |text, line| text + line + "\n");
        assert!(former.definition.contains("burn_index") && !former.definition.contains("normal_force"));
        let data = sample_from_message(&part(Vec::new())).expect("a message");
        let (data, counts) = data.split_last_chunk::<8>().expect("longer than that");
        assert_eq!(*counts, [0; 8], "the numbers of forces and of values of the centre");
        lobe_out_of_tolerance(writer);
        write_data(writer, &former, 5, data);
    }));
    let page = page.expect("a report");
    assert!(!page.contains("could not be understood"), "{page}");
    assert!(figure(&page, "Power of the wheel").contains("<path class=\"is\""), "{page}");
    assert!(figure(&page, "Normal force").contains("not recorded"), "{page}");
}

/// Without ticks the verdict stands, and the cause is said to be unknown.
#[test]
fn a_lobe_out_of_tolerance_is_not_good_and_its_worst_position_is_reported() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = bag(&dir, lobe_out_of_tolerance);
    let page = html(&path).expect("a report");
    for message in [
        "<h1>NOT GOOD</h1>",
        "2.50 µm less material than the allowed ±5.0 µm",
        "−7.50 µm</div>",
        "lobe A, cam angle 28.6°",
        "the axes&#39; ticks are not in the bag",
    ] {
        assert!(page.contains(message), "{message}: {page}");
    }
}

/// A turned part of which only the result is recorded: it is judged, and what is missing is said where it would stand.
#[test]
fn a_turned_part_without_ticks_is_judged_with_unknown_cause() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = bag(&dir, |writer| {
        let part = TurnedResult {
            name: HOSTILE.into(),
            form_error_max: 7.5e-6,
            form_error_max_azimuth: 1.0,
            form_error_max_z: 0.02,
            form_error_allowed: 10e-6,
            ..TurnedResult::default()
        };
        let done = JobStatus { turned: vec![part], job: "a job".into(), ..status(JobStatus::COMPLETE) };
        let of_job = "camwright_msgs/msg/JobStatus";
        write(writer, "/job_planner/job_status", of_job, 1, &status(JobStatus::PLANNING));
        write(writer, "/job_planner/job_status", of_job, 2, &done);
    });
    let page = html(&path).expect("a report");
    for message in [
        "<h1>GOOD</h1>",
        "part, azimuth 57.3°, z 20.00 mm",
        "<p>Not known: the axes&#39; ticks are not in the bag.</p>",
        "What made the worst place, azimuth 57.3°, z 20.00 mm",
        "the form map is not recorded",
    ] {
        assert!(page.contains(message), "{message}: {page}");
    }
    assert!(!page.contains("<script"), "{page}");
}

#[test]
fn a_bag_without_a_job_is_refused_with_what_is_missing() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = bag(&dir, |_| {});
    let error = html(&path).expect_err("there is nothing to report").to_string();
    assert!(error.ends_with("holds no job: nothing was recorded on job_planner/job_status"), "{error}");
}
