// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The operator page of a running cell in a real browser, and refusals of its server.
//!
//! Pictures of every state stay in `target/operator_page`. `CAMWRIGHT_PICTURES=FOLDER` writes those of the guide.

use crate::cell;
use crate::chromium;
use crate::support;

use camwright_msgs::camwright_msgs::action::RunJobFeedback;
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest, SetOverride, SetOverrideRequest};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest};
use camwright_operator_page::OperatorPage;
use camwright_ros::{GoalStatus, ParameterValue, RosArgs};
use camwright_run_logger::RunLogger;
use cell::{Cell, PATIENCE};
use chromium::Chromium;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use support::{Domain, Folder};

const FREE_PORT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// Text of an element.
fn text(browser: &mut Chromium, id: &str) -> String {
    browser.eval(&format!("document.getElementById('{id}').innerText")).as_str().expect("a text").to_owned()
}

fn wait_text(browser: &mut Chromium, id: &str, contains: &str) {
    browser.wait(&format!("document.getElementById('{id}').innerText.includes({contains:?})"));
}

/// Window of a panel and of a telephone (px).
const WINDOWS: [(u32, u32); 2] = [(1280, 800), (390, 844)];

/// Checks the layout in both windows, with the buttons and without.
fn is_laid_out(browser: &mut Chromium, when: &str) {
    for (width, height) in WINDOWS {
        browser.resize(width, height);
        for has_control in [true, false] {
            browser.eval(&format!("document.getElementById('control').classList.toggle('on', {has_control})"));
            // The plots follow the size of the window with the next frame.
            browser.eval("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
            let faults = browser.eval(include_str!("page_layout.js"));
            assert_eq!(faults, "", "{when}, {width} px, buttons: {has_control}");
            let is_documented = matches!(when, "held" | "complete" | "alarm");
            leave_picture(browser, &format!("{when}_{width}{}", if has_control { "_control" } else { "" }));
            if let Some(folder) = std::env::var_os("CAMWRIGHT_PICTURES")
                && is_documented
                && width == 1280
                && !has_control
            {
                let path = Path::new(&folder).join(format!("{when}.png"));
                std::fs::write(path, browser.picture(true)).expect("the folder for pictures");
            }
        }
    }
    browser.eval("document.getElementById('control').classList.add('on')");
}

/// Leaves a picture of the page in the target directory.
fn leave_picture(browser: &mut Chromium, name: &str) {
    let folder = support::target_directory().join("operator_page");
    std::fs::create_dir_all(&folder).expect("the target directory");
    std::fs::write(folder.join(format!("{name}.png")), browser.picture(true)).expect("a picture");
}

/// Stops the page in the first state for which the condition is true, checks its layout, and lets it go on.
fn check_state(browser: &mut Chromium, name: &str, condition: &str) {
    browser.wait(&format!("status && ({condition}) && (source.close(), true)"));
    is_laid_out(browser, name);
    browser.eval("connect()");
}

#[test]
fn every_state_of_the_cell_fits_on_panel_and_telephone() {
    let Some(mut browser) = Chromium::start(1280, 800) else { return };
    browser.set_color_scheme("light");
    let mut started = None;
    let mut cell = Cell::start_with(&[], |args| {
        let page = OperatorPage::start(&args, FREE_PORT, true).expect("the page");
        browser.open(&page.url());
        check_state(&mut browser, "starting", "status.state.word === 'STARTING'");
        started = Some((args.clone(), page));
        args
    });
    let ((args, page), folder) = (started.expect("the cell starts"), Folder::new("operator-page"));
    let bag = ParameterValue::String(folder.join("bag").display().to_string());
    let logger = RunLogger::start(&args.with_parameter(Some("run_logger"), "bag_dir", bag)).expect("run_logger");
    check_state(&mut browser, "not_homed", "status.state.word === 'READY' && !status.is_homed && status.recorder");
    assert!(text(&mut browser, "state").contains("the axes are not homed"));
    wait_text(&mut browser, "machine", "cam_grinder");
    wait_text(&mut browser, "verdict", "no lobe measured yet");
    wait_text(&mut browser, "homed", "not homed");
    browser.eval("window.confirm = () => true");
    click(&mut browser, "Home");
    check_state(&mut browser, "homed", "status.state.word === 'READY' && status.is_homed");

    // Held in the cut, the lobe half ground.
    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &[]);
    assert!(goal.accepted());
    while feedback.recv_timeout(PATIENCE).expect("feedback").phase_name != "cut" {}
    hold(&cell, true);
    wait_text(&mut browser, "state", "HELD");
    wait_text(&mut browser, "hold", "feed hold");
    wait_text(&mut browser, "lobe", "Lobe I1 (1 of 4)");
    wait_text(&mut browser, "job", "four_lobe_camshaft");
    wait_text(&mut browser, "recorder", "recording");
    wait_text(&mut browser, "left_title", "Stock on lobe I1 along the radius, maximum");
    browser.wait("document.querySelectorAll('#cam path').length >= 3 && document.querySelector('#cam circle')");
    check_state(&mut browser, "held", "status.state.word === 'HELD' && shape.part");
    // A fifth of the speed, so that the news of the next lobe does not come too late to slow it down.
    set_override(&cell, 0.2);
    hold(&cell, false);

    // The first lobe is judged while another is cut: slowly, since viewers see the cell only four times a second.
    let cuts_another = |job: RunJobFeedback| job.lobe_index > 0 && job.phase_name == "cut";
    while !cuts_another(feedback.recv_timeout(PATIENCE).expect("feedback")) {}
    set_override(&cell, 0.05);
    let cutting = "status.state.word === 'CUTTING' && status.cutting?.is_in_contact && status.results.length > 0 \
                   && shape.part?.name === status.lobe.name && shape.designs[0].error_um.length";
    browser.wait(&format!("status && {cutting} && (source.close(), true)"));
    wait_text(&mut browser, "verdict", "GOOD SO FAR");
    wait_text(&mut browser, "results", "GOOD");
    wait_text(&mut browser, "results", "in work");
    for value in ["Wheel power", "Normal force", "Tangential force", "Burn index"] {
        wait_text(&mut browser, "cut_values", value);
    }
    assert_eq!(browser.eval("document.querySelectorAll('#cut_values .meter').length"), 2, "normal force, burn index");
    assert_eq!(browser.eval("document.querySelectorAll('#axes .meter').length"), 3, "share of the trip level");
    is_laid_out(&mut browser, "cutting");
    browser.eval("connect()");
    set_override(&cell, 1.0);

    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    check_state(&mut browser, "complete", &complete("GOOD"));
    let worst = result.lobes.iter().max_by(|a, b| a.form_error_max.abs().total_cmp(&b.form_error_max.abs()));
    let error = format!("{:+.2} µm", worst.expect("four lobes").form_error_max * 1e6);
    wait_text(&mut browser, "results", &error);
    wait_text(&mut browser, "error_legend", "allowed ±5.0 µm");
    assert!(text(&mut browser, "verdict").contains(&error), "{}", text(&mut browser, "verdict"));

    for (job, overrides, name, verdict) in [
        ("four_lobe_camshaft", "infeed.spark_out_turns=2", "out_of_tolerance", "OUT"),
        ("plate_cam", "infeed.per_block_um=0.1", "burnt", "BURNT"),
    ] {
        let (goal, _feedback) = cell.client.send(job, &[overrides]);
        let (status, result) = goal.result(PATIENCE).expect("a result");
        assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
        check_state(&mut browser, name, &complete(verdict));
        wait_text(&mut browser, "results", verdict);
    }

    let fault = InjectFaultRequest {
        fault: "drive_fault".into(),
        target: "x_axis".into(),
        active: true,
        ..InjectFaultRequest::default()
    };
    let answer = cell.client.call::<InjectFault>("machine/inject_fault", &fault);
    assert!(answer.success, "{}", answer.message);
    browser.set_color_scheme("dark");
    check_state(&mut browser, "alarm", "status.state.word === 'ALARM 42'");
    wait_text(&mut browser, "alarms", "What to do: clear the fault at the drive, then reset");
    wait_text(&mut browser, "alarms", "x_axis");
    assert_eq!(browser.eval("document.getElementById('reset').className"), "wanted", "the reset button stands out");
    click(&mut browser, "E-STOP");
    check_state(&mut browser, "emergency_stop", "status.state.word === 'EMERGENCY STOP'");

    // Nothing came from elsewhere, and the page reports that its server has gone.
    let loaded = browser.eval(
        "performance.getEntriesByType('resource').map(e => new URL(e.name).origin === origin).every(same => same)",
    );
    assert_eq!(loaded, true);
    page.stop();
    wait_text(&mut browser, "state", "NO CONNECTION");
    is_laid_out(&mut browser, "no_connection");
    cell.release();
    cell.stop();
    logger.stop();
}

/// Condition of a complete job that is judged and drawn.
fn complete(verdict: &str) -> String {
    format!(
        "status.state.word === 'COMPLETE' && status.verdict.word === '{verdict}' && !status.cutting?.is_in_contact \
         && shape.designs.length === status.results.length && shape.designs.every(design => design.error_um.length)"
    )
}

fn hold(cell: &Cell, hold: bool) {
    let answer = cell.client.call::<SetBool>("axis_interpolator/feed_hold", &SetBoolRequest { data: hold });
    assert!(answer.success, "{}", answer.message);
}

fn set_override(cell: &Cell, feed_override: f64) {
    let answer =
        cell.client.call::<SetOverride>("axis_interpolator/set_override", &SetOverrideRequest { feed_override });
    assert!(answer.success, "{}", answer.message);
}

/// Answer of the server to some bytes, until it closes the connection.
fn answer_to(address: SocketAddr, request: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).expect("the server is there");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time");
    // It may have closed already, in the middle of what is too long.
    let _closed = stream.write_all(request);
    let mut answer = Vec::new();
    let _closed = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// A POST with a token.
fn post(address: SocketAddr, path: &str, token: &str, body: &str) -> String {
    let length = body.len();
    let head = format!("POST {path} HTTP/1.1\r\nHost: {address}\r\nX-Camwright-Token: {token}\r\n");
    format!("{head}Content-Length: {length}\r\n\r\n{body}")
}

/// Clicks the button with a text.
fn click(browser: &mut Chromium, text: &str) {
    let found = browser.eval(&format!(
        "(() => {{ const b = [...document.querySelectorAll('button')].find(b => b.innerText === {text:?}); b?.click(); return !!b; }})()"
    ));
    assert_eq!(found, true, "no button {text}");
}

/// Presses the mouse on an element, or releases it.
fn mouse(browser: &mut Chromium, kind: &str, selector: &str) {
    let at = browser.eval(&format!(
        "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{block: 'center'}}); const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()"
    ));
    let event = serde_json::json!({ "type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": 1 });
    browser.ask("Input.dispatchMouseEvent", event);
}

#[test]
fn the_page_operates_the_cell_with_its_token() {
    let Some(mut browser) = Chromium::start(1280, 900) else { return };
    let mut args = None;
    let cell = Cell::start_with(&[], |given| {
        args = Some(given.clone());
        given
    });
    let page = OperatorPage::start(&args.expect("given"), FREE_PORT, true).expect("the page");
    let (address, url) = (page.address(), page.url());
    let token = url.rsplit('#').next().expect("a token").to_owned();
    assert_eq!(token.len(), 32);
    let reset = r#"{"operation":"reset"}"#;
    for wrong in ["", "0123", &token.replace(|c: char| c.is_ascii_digit(), "x")] {
        let refused = answer_to(address, post(address, "/operate", wrong, reset).as_bytes());
        assert!(refused.starts_with("HTTP/1.1 403 ") && refused.contains("the token is wrong"), "{refused}");
    }
    let unknown = answer_to(address, post(address, "/operate", &token, r#"{"operation":"fly"}"#).as_bytes());
    assert!(unknown.starts_with("HTTP/1.1 400 "), "{unknown}");

    // Without the token the page has no buttons.
    browser.open(&format!("http://{address}/"));
    wait_text(&mut browser, "state", "READY");
    assert_eq!(browser.eval("document.getElementById('control').offsetHeight"), 0);
    browser.open(&format!("http://{address}/snapshot.json"));
    browser.open(&url);
    browser.wait("document.getElementById('control')?.offsetHeight > 0");
    assert_eq!(browser.eval("location.hash"), "", "the token leaves the address bar");
    wait_text(&mut browser, "state", "READY");

    // What moves asks first; without a confirmation nothing is sent.
    browser.eval("window.questions = []; window.confirm = text => { questions.push(text); return false; }");
    for button in ["Home", "Wheel on", "Resume"] {
        click(&mut browser, button);
    }
    assert_eq!(browser.eval("questions.length"), 3);
    assert_eq!(text(&mut browser, "answer"), "");
    browser.eval("window.confirm = () => true");
    click(&mut browser, "Home");
    wait_text(&mut browser, "answer", "homed all axes");
    mouse(&mut browser, "mousePressed", "[data-jog='1']");
    mouse(&mut browser, "mouseReleased", "[data-jog='1']");
    wait_text(&mut browser, "answer", "x_axis at ");

    // A held button gives signs of life until it is released.
    browser.eval(
        "window.paths = []; window.real_post = post; window.post = path => { paths.push(path); \
         document.body.dataset.posts = paths.length; return path === '/operate' ? new Promise(() => {}) : Promise.resolve(); }",
    );
    mouse(&mut browser, "mousePressed", "[data-jog='1']");
    browser.wait("paths.filter(path => path === '/hold-to-run').length > 2");
    mouse(&mut browser, "mouseReleased", "[data-jog='1']");
    browser.wait("paths.includes('/release')");
    assert_eq!(browser.eval("paths.shift()"), "/operate");
    assert_eq!(browser.eval("paths.at(-1)"), "/release");
    browser.eval("window.post = real_post");

    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &[]);
    assert!(goal.accepted());
    while feedback.recv_timeout(PATIENCE).expect("feedback").phase_name != "cut" {}
    click(&mut browser, "Hold");
    wait_text(&mut browser, "answer", "motion held on its path");
    wait_text(&mut browser, "state", "HELD");
    click(&mut browser, "Resume");
    wait_text(&mut browser, "answer", "motion continues");
    click(&mut browser, "E-STOP");
    wait_text(&mut browser, "state", "EMERGENCY STOP");
    wait_text(&mut browser, "verdict", "no lobe measured yet");
    click(&mut browser, "Release e-stop");
    wait_text(&mut browser, "answer", "emergency stop released");
    click(&mut browser, "Reset alarms");
    wait_text(&mut browser, "answer", "alarms reset");
    browser.wait("status.alarms.every(alarm => alarm.severity === 'warning')");
    page.stop();
    cell.stop();
}

#[test]
fn the_server_gives_what_it_has_and_nothing_else() {
    let domain = Domain::reserve();
    let args = RosArgs::default().with_domain_id(domain.id());
    let page = OperatorPage::start(&args, FREE_PORT, false).expect("the page");
    let address = page.address();
    assert!(address.ip().is_loopback());
    let get = |path: &str| answer_to(address, format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes());
    let html = get("/");
    assert!(html.starts_with("HTTP/1.1 200 OK\r\n") && html.contains("Content-Security-Policy: default-src 'none'"));
    let elsewhere =
        html.match_indices("//").filter(|(at, _)| html[..*at].ends_with("http:") || html[..*at].ends_with("https:"));
    assert!(elsewhere.clone().all(|(at, _)| html[at..].starts_with("//www.w3.org/2000/svg")), "all is in the page");
    let snapshot = get("/snapshot.json");
    let body = snapshot.split("\r\n\r\n").nth(1).expect("a body");
    let value: serde_json::Value = serde_json::from_str(body).expect("JSON");
    assert_eq!(value["status"]["state"]["word"], "STARTING");
    assert_eq!(
        (&value["status"]["recorder"], &value["shape"]["part"]),
        (&serde_json::Value::Null, &serde_json::Value::Null)
    );

    for path in ["/../../../etc/passwd", "/..%2f..%2fetc/passwd", "/page.html", "/status"] {
        assert!(get(path).starts_with("HTTP/1.1 404 "), "{path}");
    }
    let refused =
        answer_to(address, format!("POST / HTTP/1.1\r\nHost: {address}\r\nContent-Length: 0\r\n\r\n").as_bytes());
    assert!(refused.starts_with("HTTP/1.1 405 ") && refused.contains("\r\nAllow: GET, POST\r\n"), "{refused}");
    let operate = answer_to(address, post(address, "/operate", "", r#"{"operation":"reset"}"#).as_bytes());
    assert!(operate.starts_with("HTTP/1.1 403 ") && operate.contains("start the page with --control"), "{operate}");
    let foreign = answer_to(address, b"GET /snapshot.json HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    assert!(foreign.starts_with("HTTP/1.1 403 "), "{foreign}");
    assert!(answer_to(address, b"\x16\x03\x01\x02\r\n\r\n").starts_with("HTTP/1.1 400 "));
    // A head without end is refused by its size or, if it comes slowly, by its time.
    let long = [b"GET / HTTP/1.1\r\nx: ".as_slice(), &[b'a'; 9000]].concat();
    let refused = answer_to(address, &long);
    assert!(refused.starts_with("HTTP/1.1 431 ") || refused.is_empty(), "{refused}");
    assert!(answer_to(address, b"GET / HT").starts_with("HTTP/1.1 408 "), "half a request");

    // However many viewers there are, the next one is served: one that does not read gives its seat up.
    let mut viewers: Vec<TcpStream> = Vec::new();
    for _ in 0..40 {
        let mut viewer = TcpStream::connect(address).expect("the server is there");
        viewer.set_read_timeout(Some(PATIENCE)).expect("a time");
        viewer.write_all(format!("GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes()).expect("it is taken");
        let mut first = [0; 15];
        viewer.read_exact(&mut first).expect("an answer");
        assert_eq!(&first, b"HTTP/1.1 200 OK");
        viewers.push(viewer);
    }
    for _ in 0..3 {
        assert!(get("/").starts_with("HTTP/1.1 200 "));
    }
    drop(viewers);

    let taken = OperatorPage::start(&args, address, false).expect_err("the port is taken").to_string();
    assert!(taken.starts_with(&format!("the operator page cannot be served at {address}: ")), "{taken}");
    page.stop();
    assert!(TcpStream::connect(address).is_err(), "nobody listens any more");
}

/// The command beside a cell prints the address of the page; a port in use is one clear error.
#[test]
fn the_command_serves_the_page_until_it_is_interrupted() {
    let (domain, folder) = (Domain::reserve(), Folder::new("page-command"));
    let command = |port: u16| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.args(["page", "--port", &port.to_string()]).env("ROS_DOMAIN_ID", domain.id().to_string());
        command.current_dir(folder.path());
        command
    };
    let mut page = support::Guarded::start("camwright page", &mut command(0));
    let mut address = None;
    for _ in 0..900 {
        let stderr = page.stderr();
        address = stderr
            .lines()
            .find_map(|line| line.strip_prefix("operator page: http://")?.strip_suffix('/')?.parse().ok());
        if address.is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    let address: SocketAddr = address.unwrap_or_else(|| panic!("no address is printed{}", page.complaint()));
    assert!(
        answer_to(address, format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes())
            .contains("<title>camwright cell")
    );
    let second = command(address.port()).output().expect("it starts");
    let stderr = String::from_utf8_lossy(&second.stderr);
    assert!(second.status.code() == Some(1) && stderr.contains("cannot be served at"), "{stderr}");
    page.interrupt();
    let status = page.wait(support::PATIENCE);
    assert!(status.success(), "{status}{}", page.complaint());
}
