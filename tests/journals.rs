//! Journals that run out, ground by the whole cell: measured, decided, corrected in a second plan, and recorded.

mod support;

use byteorder::LittleEndian;
use camwright_msgs::camwright_msgs::msg::{PartLobe, PlanPage};
use camwright_nodes::bag::Bag;
use std::process::Command;
use support::{Domain, Folder};

const TWO: &str = "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0, width_mm: 20}, \
     {name: J2, station: LS2, profile: journal, phase_deg: 40, width_mm: 20}]";

/// What a run of two of the shipped journals leaves: what it reports, the finished part, and the halves of its plans in the bag.
fn ground(folder: &Folder, name: &str) -> (serde_json::Value, Vec<PartLobe>, Vec<u8>) {
    let (domain, bag) = (Domain::take(), folder.join(name));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join(&format!("{name}-state")));
    let output = command.args(["run", "journal_runout", "--json", "--set", TWO, "--bag"]).arg(&bag).output();
    let output = output.expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (mut part, mut halves) = (Vec::new(), Vec::new());
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

/// Two of the shipped journals over DDS: rounder than a micrometre and a half, to size, with both plans in the bag. Done once more, by
/// nodes whose messages came at other times, the part is the same bit for bit.
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
    assert_eq!(halves, [1, 2], "a first half and a second");
    assert_eq!(part.iter().map(|lobe| lobe.name.as_str()).collect::<Vec<_>>(), ["J1", "J2"]);
    let (_, again, _) = ground(&folder, "two");
    for (lobe, again) in part.iter().zip(&again) {
        let bits = |lobe: &PartLobe| lobe.radius.iter().map(|radius| radius.to_bits()).collect::<Vec<u64>>();
        assert!(bits(lobe) == bits(again), "lobe {}", lobe.name);
    }
}
