// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped slender camshaft, planned from the command line: stiffness of each lobe, spark-out, order, the drawing, and what is refused.

use crate::support;

use support::{Folder, camwright, refusal_of_check};

/// Every lobe has its stiffness and its spark-out in the summary, in the text and on a drawing; a job without the keys has neither.
#[test]
fn a_slender_part_is_planned_with_the_stiffness_of_each_lobe() {
    let folder = Folder::new("steady-rest");
    let out = folder.path().display().to_string();
    let output = camwright(&["plan", "long_camshaft", "--json", "--plots", "--out", &out], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a summary in JSON");
    let lobes = summary["lobes"].as_array().expect("lobes");
    assert_eq!(lobes.len(), 6);
    for lobe in lobes {
        let value = |key: &str| lobe["part_support"][key].as_f64().unwrap_or_else(|| panic!("{key} in {lobe}"));
        let series = 1.0 / (1.0 / 45.0 + value("part_compliance_um_n"));
        assert!((value("stiffness_n_um") / series - 1.0).abs() < 1e-9, "{lobe}");
        assert!((1.0..=5.0).contains(&value("spark_out_turns_needed")), "the shipped job states enough: {lobe}");
        let name = lobe["name"].as_str().expect("a name");
        let drawing = std::fs::read_to_string(folder.join(&format!("{name}/compliance.svg"))).expect("a drawing");
        assert!(drawing.contains("without steady rest"), "{name}");
    }
    let output = camwright(&["plan", "long_camshaft", "--details", "--out", &out], &[]);
    let text = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    for words in ["support I1: part ", "support: grind the seat of the steady rest at 225 mm", "ask for no order"] {
        assert!(text.contains(words), "{words:?} is not in {text}");
    }
    let output = camwright(&["plan", "eccentric", "--json", "--out", &out], &[]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(!text.contains("part_support") && !text.contains("support_order"), "{text}");
}

/// One key wrong each: the refusal names it, what is wrong, and what would do.
#[test]
fn supports_that_cannot_hold_the_part_are_refused() {
    for (set, words) in [
        (
            vec![
                "machine=cam_grinder",
                "lobes=[{name: I1, station: LS1, profile: intake, phase_deg: 0, width_mm: 14}]",
            ],
            ["machine cam_grinder states no stiffness of its supports; add workholding", "long_camshaft.yaml"],
        ),
        (vec!["part_support.tailstock=false"], ["needs the tailstock", "headstock to chuck"]),
        (vec!["part_support.steady_rest_z_mm=185.0"], ["lobe I2 reaches from 173 to 187 mm", "under the jaws"]),
        (vec!["part_support.steady_rest_z_mm=419.0"], ["steady_rest_z_mm is 419", "it must be 36 to 414"]),
        (vec!["part_support.length_mm=340.0"], ["lobe E3 reaches from 363 to 377 mm", "from 30 to 370 mm"]),
        (vec!["part_support.headstock_z_mm=75.0"], ["lobe I1 reaches from 73 to 87 mm", "must stand between"]),
        (vec!["part_support.diameter_mm=0.5"], ["part_support.diameter_mm is 0.5", "1 to 1000"]),
        (vec!["part_support.modulus_gpa=210000"], ["part_support.modulus_gpa is 210000", "1 to 1000"]),
        (vec!["part_support.length_mm=5"], ["part_support.length_mm is 5", "10 to 10000"]),
        (vec!["part_support={diameter_mm: 28.0}"], ["headstock_z_mm", "length_mm"]),
        (vec!["part_support.headstock=collet"], ["collet", "centre, chuck"]),
    ] {
        let text = refusal_of_check("long_camshaft", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
}

/// A machine file without a support that the job needs, or with one that is none.
#[test]
fn supports_that_the_machine_lacks_are_refused() {
    const CHUCK: &str = "part_support.headstock=chuck";
    let shipped = support::repository().join("params/machines/cam_grinder_with_steady_rest.yaml");
    let shipped = std::fs::read_to_string(shipped).expect("the shipped machine");
    let folder = Folder::new("steady-rest-machines");
    for (number, (from, to, set, words)) in [
        (
            "  steady_rest: {stiffness_n_um: 60.0, jaw_width_mm: 12.0}\n",
            "",
            "",
            ["states no steady rest; add workholding.steady_rest", "long_camshaft.yaml"],
        ),
        (
            "  tailstock_stiffness_n_um: 100.0\n",
            "",
            "",
            ["states no stiffness of a tailstock", "leave that support out"],
        ),
        (
            "  chuck_tilt_n_m_rad: 2000000.0\n",
            "",
            CHUCK,
            ["states no tilting stiffness of a chuck", "chuck_tilt_n_m_rad"],
        ),
        ("headstock_stiffness_n_um: 150.0", "headstock_stiffness_n_um: 0", "", ["is 0", "0.1 to 10000"]),
        ("jaw_width_mm: 12.0", "jaw_width_mm: -1", "", ["jaw_width_mm is -1", "0.1 to 1000"]),
        ("contact:\n", "unused:\n", "", ["unused is an unknown key", "machine.yaml"]),
    ]
    .into_iter()
    .enumerate()
    {
        assert!(shipped.contains(from), "{from}");
        let path = folder.join(&format!("{number}-machine.yaml"));
        std::fs::write(&path, shipped.replacen(from, to, 1)).expect("a machine file");
        let machine = format!("machine={}", path.display());
        let set: Vec<&str> = [machine.as_str(), set].into_iter().filter(|set| !set.is_empty()).collect();
        let text = refusal_of_check("long_camshaft", &set);
        for word in words {
            assert!(text.contains(word), "{set:?}: {word:?} is not in {text}");
        }
    }
    let start = shipped.find("contact:\n").expect("a contact");
    let end = shipped.find("# Radial stiffness").expect("supports");
    let path = folder.join("rigid-machine.yaml");
    std::fs::write(&path, format!("{}{}", &shipped[..start], &shipped[end..])).expect("a machine file");
    let text = refusal_of_check("long_camshaft", &[&format!("machine={}", path.display())]);
    assert!(text.contains("workholding needs contact: without it the machine is rigid"), "{text}");
}
