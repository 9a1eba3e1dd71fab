// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The report of recorded runs, read by a real browser: someone who sees its first screen and nothing else knows whether the part is good, and why.
//!
//! With `CAMWRIGHT_PICTURES=FOLDER` it leaves pictures of the pages there.

use crate::chromium;
use crate::support;

use chromium::Chromium;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use support::{Domain, Folder};

/// The screen on which everything that matters is seen at once.
const SCREEN: (u32, u32) = (1280, 900);

/// Largest page of a job (B).
const MAX_BYTES: usize = 1_000_000;

/// One browser at a time: on a small machine several that start together may not answer in time.
static BROWSER: Mutex<()> = Mutex::new(());

/// Runs a job at pace fast; what it said as JSON, and its bag.
fn run(folder: &Folder, job: &str, set: &[&str]) -> (Value, PathBuf) {
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(["run", job, "--json", "--bag"]).arg(&bag);
    for over in set {
        command.args(["--set", over]);
    }
    let output = command.output().expect("camwright runs");
    let report = serde_json::from_slice(&output.stdout);
    (report.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr))), bag)
}

/// The page that the run left, which the command makes again from the bag alone, byte by byte.
fn page(folder: &Folder, report: &Value, bag: &Path) -> (PathBuf, String) {
    let path = PathBuf::from(report["report"].as_str().expect("where the report is"));
    assert_eq!(path, bag.join("report.html"));
    let again = folder.join("again.html");
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    let output = command.args(["bag", "report"]).arg(bag).arg("--out").arg(&again).output().expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |path: &Path| std::fs::read_to_string(path).expect("a page");
    let (first, second) = (read(&path), read(&again));
    assert!(first == second, "the same bag gives the same bytes");
    assert!(first.len() < MAX_BYTES, "{} bytes", first.len());
    (path, first)
}

/// The first screen has these four, each with the words that it must have, and nothing on it is cut off or lies over something else.
fn first_screen(browser: &mut Chromium, path: &Path, name: &str, words: [(&str, &[String]); 4]) {
    for scheme in ["light", "dark"] {
        browser.set_color_scheme(scheme);
        browser.open(&format!("file://{}", path.display()));
        for (id, words) in &words {
            let place = browser.eval(&format!(
                "(() => {{ const box = document.getElementById('{id}').getBoundingClientRect(); return [box.top, box.bottom, box.left, box.right]; }})()"
            ));
            let at = |index: usize| place[index].as_f64().expect("a place");
            let (width, height) = SCREEN;
            assert!(
                at(0) >= 0.0 && at(1) <= f64::from(height) && at(2) >= 0.0 && at(3) <= f64::from(width),
                "{id}: {place}"
            );
            let text = browser.eval(&format!("document.getElementById('{id}').innerText"));
            let text = text.as_str().expect("a text");
            assert!(words.iter().all(|word| text.contains(word)), "{name}: {id} has not all of {words:?}: {text}");
        }
        let wrong = browser.eval(
            "(() => { const wrong = []; const root = document.documentElement;
              if (root.scrollWidth > innerWidth) wrong.push('the page is ' + root.scrollWidth + ' wide');
              for (const tile of document.querySelectorAll('.tile div, .tile p, h1, .verdict p'))
                if (tile.scrollWidth > tile.clientWidth + 1) wrong.push('cut off: ' + tile.innerText);
              for (const svg of document.querySelectorAll('svg')) { const edge = svg.getBoundingClientRect();
                const texts = [...svg.querySelectorAll('text')].map(t => [t, t.getBoundingClientRect()]);
                for (const [t, box] of texts) if (box.left < edge.left - 1 || box.right > edge.right + 1 || box.top < edge.top - 1 || box.bottom > edge.bottom + 1)
                  wrong.push('outside of its drawing: ' + t.textContent); }
              for (const svg of document.querySelectorAll('svg.part')) { const boxes = [...svg.querySelectorAll('text')].map(t => [t, t.getBoundingClientRect()]);
                boxes.forEach(([t, a], index) => { for (const [u, b] of boxes.slice(index + 1))
                  if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom) wrong.push(t.textContent + ' lies over ' + u.textContent); }); }
              return wrong.join('; '); })()",
        );
        assert_eq!(wrong, "", "{name}, {scheme}");
        let ground = browser.eval("getComputedStyle(document.body).backgroundColor");
        let is_dark = ground.as_str().is_some_and(|ground| ground == "rgb(17, 22, 27)");
        assert_eq!(is_dark, scheme == "dark", "{ground}");
        picture(browser, &format!("report-{name}-{scheme}"));
    }
    assert_eq!(browser.eval("document.scripts.length"), 0, "{name}: a script");
    assert_eq!(browser.eval("performance.getEntriesByType('resource').length"), 0, "{name}: something from elsewhere");
}

fn picture(browser: &mut Chromium, name: &str) {
    if let Some(folder) = std::env::var_os("CAMWRIGHT_PICTURES") {
        let path = Path::new(&folder).join(format!("{name}.png"));
        std::fs::write(path, browser.picture(false)).expect("the folder for pictures");
    }
}

/// A micrometre figure as the page writes it.
fn signed(um: f64) -> String {
    format!("{um:+.2} µm").replace('-', "−")
}

fn texts(of: &[&str]) -> Vec<String> {
    of.iter().map(|text| (*text).to_owned()).collect()
}

/// The worst lobe of a run: name, error (µm), cam angle (deg).
fn worst(report: &Value) -> (String, f64, f64) {
    let lobes = report["lobes"].as_array().expect("lobes");
    let error = |lobe: &Value| lobe["form_error_max_um"].as_f64().expect("a number");
    let lobe = lobes.iter().max_by(|a, b| error(a).abs().total_cmp(&error(b).abs())).expect("a lobe");
    let name = lobe["name"].as_str().expect("a name").to_owned();
    (name, error(lobe), lobe["form_error_max_deg"].as_f64().expect("an angle"))
}

/// The inspection has a row of figures for every lobe: no lift error of a zone is larger than the form error allows.
fn inspected(html: &str, report: &Value) {
    let section = html.split("id=\"inspection\"").nth(1).and_then(|rest| rest.split("</table>").next());
    let rows: Vec<&str> = section.expect("a table of the inspection").split("<tr>").skip(2).collect();
    let lobes = report["lobes"].as_array().expect("lobes");
    assert_eq!(rows.len(), lobes.len(), "{rows:?}");
    for (row, lobe) in rows.iter().zip(lobes) {
        let cells: Vec<String> = row
            .split("<td")
            .skip(1)
            .map(|cell| cell.split(['>', '<']).nth(1).unwrap_or("").replace('−', "-"))
            .collect();
        let number = |cell: usize| cells[cell].parse::<f64>().unwrap_or_else(|_| panic!("{cells:?} at {cell}"));
        assert_eq!(cells[0], lobe["name"], "{cells:?}");
        // Twice the largest form error bounds size and runout of the base circle.
        let bound_um = 2.0 * lobe["form_error_max_um"].as_f64().expect("a number").abs();
        assert!(number(1).abs() <= bound_um, "{cells:?}, bound {bound_um}");
        assert!(cells[4] == "–" || number(4) <= bound_um, "{cells:?}, bound {bound_um}");
        assert_eq!(cells[9].matches('(').count(), 3, "{cells:?}");
    }
}

fn grinding(name: &str, job: &str, set: &[&str], verdict: &str, cause: &[&str], holds: &[&str]) {
    let folder = Folder::new(&format!("report-{name}"));
    let (report, bag) = run(&folder, job, set);
    let (path, html) = page(&folder, &report, &bag);
    for section in holds {
        assert!(html.contains(section), "{name}: {section}");
    }
    inspected(&html, &report);
    assert!(!html.contains("not recorded"), "{name}: everything that is drawn was recorded");
    assert!(html.contains("yes, to the same plan"), "{name}: planned again to the plan that was driven");
    let (lobe, error_um, deg) = worst(&report);
    assert_eq!(error_um.abs() <= 5.0, verdict == "GOOD", "{name}: {error_um} um");
    let _alone = BROWSER.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut browser) = Chromium::start(SCREEN.0, SCREEN.1) else { return };
    let place = texts(&[&signed(error_um), &format!("lobe {lobe}, cam angle {deg:.1}°")]);
    first_screen(
        &mut browser,
        &path,
        name,
        [("verdict", &texts(&[verdict])), ("worst", &place), ("bound", &texts(&["±5.0 µm"])), ("cause", &texts(cause))],
    );
}

#[test]
fn a_good_camshaft_is_seen_to_be_good() {
    let holds = ["id=\"time\"", "id=\"alarms\"", "id=\"losses\"", "id=\"provenance\"", "Removal rate Q′", "Burn index"];
    grinding(
        "good",
        "four_lobe_camshaft",
        &["infeed.total_mm=0.072", "stock_mm=0.06"],
        "GOOD",
        &["At that place", "lag by the encoders"],
        &holds,
    );
}

#[test]
fn a_camshaft_that_is_ground_too_fast_is_seen_to_be_bad_and_why() {
    let fast = ["speed.law=constant_removal_rate", "speed.removal_rate_mm2_s=10", "work_speed_rpm=300"];
    let cause = ["Mostly the structures of the axes", "swing of the structures"];
    grinding("bad", "four_lobe_camshaft", &fast, "NOT GOOD", &cause, &["removal rate"]);
}

#[test]
fn journals_show_their_runout_before_and_after() {
    let holds = [
        "id=\"gauge\"",
        "runout before µm",
        "expected after it µm",
        "last turn before the correction",
        "last part of the job",
    ];
    grinding("runout", "journal_runout", &[], "GOOD", &["At that place"], &holds);
}

/// The causes at a turned part's worst position add up to the deviation there; the unexplained remainder is small.
fn parts_are_the_deviation(html: &str, error_um: f64) {
    let table = html.split("What made the worst place").nth(1).and_then(|rest| rest.split("</table>").next());
    let rows = table.expect("a table of the worst place").split("<tr>").skip(2);
    let left = |row: &str| -> Vec<f64> {
        let cells = row.split("<td>").skip(1).map(|cell| cell.split('<').next().unwrap_or(""));
        let numbers: Vec<Option<f64>> = cells.map(|cell| cell.replace('−', "-").parse().ok()).collect();
        // Behind each way that an axis is off stands what that leaves.
        [1, 3].into_iter().filter_map(|cell| numbers[cell]).collect()
    };
    let rows: Vec<(&str, Vec<f64>)> = rows.map(|row| (row, left(row))).collect();
    let (sum, parts) = rows.split_last().expect("rows");
    assert_eq!(parts.len(), 5, "three axes, cusp and rest: {parts:?}");
    assert!((sum.1[0] - error_um).abs() < 0.006, "{sum:?}, reported are {error_um} um");
    let all: f64 = parts.iter().flat_map(|(_, left)| left).sum();
    assert!((all - error_um).abs() < 0.005 * 9.0, "{all} um in parts, reported are {error_um} um: {parts:?}");
    let rest = parts.last().map(|(_, left)| left[0]).expect("a rest");
    assert!(rest.abs() < 0.2 * error_um.abs(), "{rest} of {error_um} um are not explained: {parts:?}");
}

#[test]
fn a_turned_part_is_shown_where_it_is_worst() {
    let folder = Folder::new("report-turned");
    let short = ["turned.to_mm=22", "form_grid.azimuths=180", "finishing.along_z_mm=0.3", "roughing.along_z_mm=0.8"];
    let (report, bag) = run(&folder, "turned_cam", &short);
    let (path, html) = page(&folder, &report, &bag);
    assert!(html.contains("form map") && html.contains("id=\"turned\"") && html.contains("yes, to the same plan"));
    let turned = |key: &str| report["turned"][key].as_f64().expect("a number");
    let place = format!("azimuth {:.1}°, z {:.2} mm", turned("form_error_max_deg"), turned("form_error_max_z_mm"));
    let allowed = format!("±{:.1} µm", turned("form_error_allowed_um"));
    let verdict = if report["good"] == true { "GOOD" } else { "NOT GOOD" };
    let _alone = BROWSER.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut browser) = Chromium::start(SCREEN.0, SCREEN.1) else { return };
    let worst = texts(&[&signed(turned("form_error_max_um")), &place]);
    let cause = texts(&["At that place", "X off its setpoint", "cusp of the feed", "In the last pass X was"]);
    parts_are_the_deviation(&html, turned("form_error_max_um"));
    // Some µm by either way of looking, not the way to the part and back.
    let off = html.split("In the last pass X was ").nth(1).and_then(|rest| rest.split(" off").next()).expect("how far");
    let numbers = off.replace('−', "-").replace("µm", "");
    let far = numbers
        .split_whitespace()
        .filter_map(|word| word.parse::<f64>().ok())
        .fold(0.0, |far: f64, um| far.max(um.abs()));
    assert!((1.0..20.0).contains(&far), "X was {off} off its path");
    let words: [(&str, &[String]); 4] =
        [("verdict", &texts(&[verdict])), ("worst", &worst), ("bound", &[allowed]), ("cause", &cause)];
    first_screen(&mut browser, &path, "turned", words);
}

/// A drive fails in the cut: the first screen says which alarm, and what to do.
#[test]
fn a_job_ended_by_an_alarm_reports_it() {
    let folder = Folder::new("report-alarm");
    let (report, bag) = run(&folder, "four_lobe_camshaft", &["faults=[{kind: drive_fault, target: x_axis, at_s: 12}]"]);
    assert_eq!(report["good"], false, "{report}");
    let (path, _) = page(&folder, &report, &bag);
    let _alone = BROWSER.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut browser) = Chromium::start(SCREEN.0, SCREEN.1) else { return };
    let words: [(&str, &[String]); 4] = [
        ("verdict", &texts(&["NOT COMPLETE", "Alarm 42", "x_axis"])),
        ("worst", &texts(&["nothing was judged"])),
        ("bound", &texts(&["Allowed"])),
        ("cause", &texts(&["clear the fault at the drive, then reset"])),
    ];
    first_screen(&mut browser, &path, "alarm", words);
}
