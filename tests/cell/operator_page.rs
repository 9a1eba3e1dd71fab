//! The operator page of a running cell, read by a real browser; and what its server refuses.
//!
//! With `CAMWRIGHT_PICTURES=FOLDER` it leaves pictures of the page there.

use crate::cell;
use crate::chromium;
use crate::support;

use camwright_msgs::camwright_msgs::srv::{FeedHold, FeedHoldRequest, InjectFault, InjectFaultRequest};
use camwright_operator_page::OperatorPage;
use camwright_ros::{GoalStatus, ParameterValue, RosArgs};
use camwright_run_logger::RunLogger;
use cell::{Cell, PATIENCE};
use chromium::Chromium;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use support::{Domain, Folder};

const FREE_PORT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// Text of an element.
fn text(browser: &mut Chromium, id: &str) -> String {
    browser.eval(&format!("document.getElementById('{id}').innerText")).as_str().expect("a text").to_owned()
}

fn wait_text(browser: &mut Chromium, id: &str, contains: &str) {
    browser.wait(&format!("document.getElementById('{id}').innerText.includes({contains:?})"));
}

/// Nothing is cut off, nothing lies over something else, nothing is wider than the page.
fn is_laid_out(browser: &mut Chromium, when: &str) {
    let wrong = browser.eval(
        "(() => { const wrong = []; const root = document.documentElement;
          if (root.scrollWidth > innerWidth) wrong.push('the page is ' + root.scrollWidth + ' wide');
          for (const word of document.querySelectorAll('.word div')) if (word.scrollWidth > word.clientWidth + 1) wrong.push('cut off: ' + word.innerText);
          const boxes = [...document.querySelectorAll('header, .word, .alarm, section')].map(e => [e, e.getBoundingClientRect()]);
          for (const [a, p] of boxes) for (const [b, q] of boxes) if (a !== b && !a.contains(b) && !b.contains(a)
            && p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1)
            wrong.push((a.id || a.className || a.tagName) + ' lies over ' + (b.id || b.className || b.tagName));
          for (const svg of document.querySelectorAll('svg')) { const edge = svg.getBoundingClientRect();
            const texts = [...svg.querySelectorAll('text')].map(t => [t, t.getBoundingClientRect()]);
            for (const [t, box] of texts) if (box.left < edge.left - 1 || box.right > edge.right + 1 || box.top < edge.top - 1 || box.bottom > edge.bottom + 1)
              wrong.push('outside of ' + svg.id + ': ' + t.textContent);
            texts.forEach(([a, p], i) => texts.slice(i + 1).forEach(([b, q]) => { if (p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1)
              wrong.push(a.textContent + ' lies over ' + b.textContent); })); }
          for (const part of document.querySelectorAll('section, section > div, td')) if (part.scrollWidth > part.clientWidth + 1) wrong.push('too wide: ' + part.innerText.slice(0, 40));
          for (const part of document.querySelectorAll('section')) if (part.scrollHeight > part.clientHeight + 1) wrong.push('too high: ' + part.innerText.slice(-40));
          return wrong.join('; '); })()",
    );
    assert_eq!(wrong, "", "{when}");
}

fn picture(browser: &mut Chromium, name: &str) {
    if let Some(folder) = std::env::var_os("CAMWRIGHT_PICTURES") {
        let path = std::path::Path::new(&folder).join(format!("{name}.png"));
        std::fs::write(path, browser.picture()).expect("the folder for pictures");
    }
}

#[test]
fn a_browser_sees_what_the_cell_does() {
    let Some(mut browser) = Chromium::start(1366, 768) else { return };
    let mut args = None;
    let cell = Cell::start_with(&[], |given| {
        args = Some(given.clone());
        given
    });
    let (args, folder) = (args.expect("given"), Folder::new("operator-page"));
    let bag = ParameterValue::String(folder.join("bag").display().to_string());
    let logger =
        RunLogger::start(&args.clone().with_parameter(Some("run_logger"), "bag_dir", bag)).expect("run_logger");
    let page = OperatorPage::start(&args, FREE_PORT, false).expect("the page");
    browser.wish_for("light");
    browser.open(&format!("http://{}/", page.address()));
    wait_text(&mut browser, "state", "READY");
    wait_text(&mut browser, "machine", "cam_grinder");
    wait_text(&mut browser, "verdict", "no lobe measured yet");
    is_laid_out(&mut browser, "ready");

    // Held in the cut, the lobe half ground.
    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &[]);
    assert!(goal.accepted());
    while feedback.recv_timeout(PATIENCE).expect("feedback").phase_name != "cut" {}
    let hold = |hold: bool| {
        let answer = cell.client.call::<FeedHold>("axis_interpolator/feed_hold", &FeedHoldRequest { hold });
        assert!(answer.success, "{}", answer.message);
    };
    hold(true);
    wait_text(&mut browser, "state", "HELD");
    wait_text(&mut browser, "hold", "feed hold");
    wait_text(&mut browser, "lobe", "Lobe I1 (1 of 4)");
    wait_text(&mut browser, "job", "four_lobe_camshaft");
    wait_text(&mut browser, "recorder", "recording");
    wait_text(&mut browser, "left_title", "Stock on lobe I1 along the radius, maximum");
    browser.wait("document.querySelectorAll('#cam path').length >= 3 && document.querySelector('#cam circle')");
    is_laid_out(&mut browser, "held");
    picture(&mut browser, "held");
    hold(false);

    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    wait_text(&mut browser, "state", "COMPLETE");
    wait_text(&mut browser, "verdict", "GOOD");
    let worst = result.lobes.iter().max_by(|a, b| a.form_error_max.abs().total_cmp(&b.form_error_max.abs()));
    let error = format!("{:+.2} µm", worst.expect("four lobes").form_error_max * 1e6);
    wait_text(&mut browser, "results", &error);
    wait_text(&mut browser, "error_legend", "allowed ±5.0 µm");
    assert!(text(&mut browser, "verdict").contains(&error), "{}", text(&mut browser, "verdict"));
    is_laid_out(&mut browser, "complete");
    picture(&mut browser, "complete");

    let fault = InjectFaultRequest {
        fault: "drive_fault".into(),
        target: "x_axis".into(),
        active: true,
        ..InjectFaultRequest::default()
    };
    let answer = cell.client.call::<InjectFault>("machine/inject_fault", &fault);
    assert!(answer.success, "{}", answer.message);
    wait_text(&mut browser, "state", "ALARM 42");
    wait_text(&mut browser, "alarms", "What to do: clear the fault at the drive, then reset");
    wait_text(&mut browser, "alarms", "x_axis");
    browser.wish_for("dark");
    is_laid_out(&mut browser, "alarm");
    picture(&mut browser, "alarm");
    browser.resize(420, 900);
    browser.wait("document.documentElement.scrollWidth <= innerWidth");

    // Nothing came from elsewhere, and the page says so when its server has gone.
    let loaded = browser.eval(
        "performance.getEntriesByType('resource').map(e => new URL(e.name).origin === origin).every(same => same)",
    );
    assert_eq!(loaded, true);
    page.stop();
    wait_text(&mut browser, "state", "NO CONNECTION");
    cell.stop();
    logger.stop();
}

/// Answer of the server to some bytes, until it closes the connection.
fn answered(address: SocketAddr, request: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).expect("the server is there");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time");
    // It may have closed already, in the middle of what is too long.
    let _closed = stream.write_all(request);
    let mut answer = Vec::new();
    let _closed = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// A POST with a token.
fn posted(address: SocketAddr, path: &str, token: &str, body: &str) -> String {
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
        let refused = answered(address, posted(address, "/operate", wrong, reset).as_bytes());
        assert!(refused.starts_with("HTTP/1.1 403 ") && refused.contains("the token is wrong"), "{refused}");
    }
    let unknown = answered(address, posted(address, "/operate", &token, r#"{"operation":"fly"}"#).as_bytes());
    assert!(unknown.starts_with("HTTP/1.1 400 "), "{unknown}");

    // Without the token the page has no buttons.
    browser.open(&format!("http://{address}/"));
    wait_text(&mut browser, "state", "READY");
    assert_eq!(browser.eval("document.getElementById('control').offsetHeight"), 0);
    browser.open(&format!("http://{address}/snapshot.json"));
    browser.open(&url);
    browser.wait("document.getElementById('control')?.offsetHeight > 0");
    assert_eq!(browser.eval("location.hash"), "", "the token leaves the address bar");
    browser.eval("window.confirm = () => true");
    wait_text(&mut browser, "state", "READY");
    is_laid_out(&mut browser, "ready with control");
    click(&mut browser, "Home");
    wait_text(&mut browser, "answer", "homed all axes");
    mouse(&mut browser, "mousePressed", "[data-jog='1']");
    browser.wait("document.getElementById('axes').innerText.includes('x_axis')");
    mouse(&mut browser, "mouseReleased", "[data-jog='1']");
    wait_text(&mut browser, "answer", "x_axis at ");

    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &[]);
    assert!(goal.accepted());
    while feedback.recv_timeout(PATIENCE).expect("feedback").phase_name != "cut" {}
    click(&mut browser, "Hold");
    wait_text(&mut browser, "answer", "motion held on its path");
    wait_text(&mut browser, "state", "HELD");
    is_laid_out(&mut browser, "held with control");
    click(&mut browser, "Resume");
    wait_text(&mut browser, "answer", "motion continues");
    click(&mut browser, "E-STOP");
    wait_text(&mut browser, "state", "EMERGENCY STOP");
    browser.resize(390, 844);
    browser.wait("document.documentElement.scrollWidth <= innerWidth");
    is_laid_out(&mut browser, "emergency stop at 390 px");
    picture(&mut browser, "control_390");
    click(&mut browser, "Release e-stop");
    wait_text(&mut browser, "answer", "emergency stop released");
    click(&mut browser, "Reset alarms");
    wait_text(&mut browser, "answer", "alarms reset");
    browser.resize(1280, 900);
    picture(&mut browser, "control");
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
    let get = |path: &str| answered(address, format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes());
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
    let post = answered(address, format!("POST / HTTP/1.1\r\nHost: {address}\r\nContent-Length: 0\r\n\r\n").as_bytes());
    assert!(post.starts_with("HTTP/1.1 405 ") && post.contains("\r\nAllow: GET, POST\r\n"), "{post}");
    let operate = answered(address, posted(address, "/operate", "", r#"{"operation":"reset"}"#).as_bytes());
    assert!(operate.starts_with("HTTP/1.1 403 ") && operate.contains("start the page with --control"), "{operate}");
    let foreign = answered(address, b"GET /snapshot.json HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    assert!(foreign.starts_with("HTTP/1.1 403 "), "{foreign}");
    assert!(answered(address, b"\x16\x03\x01\x02\r\n\r\n").starts_with("HTTP/1.1 400 "));
    // A head without end is refused by its size or, if it comes slowly, by its time.
    let long = [b"GET / HTTP/1.1\r\nx: ".as_slice(), &[b'a'; 9000]].concat();
    let refused = answered(address, &long);
    assert!(refused.starts_with("HTTP/1.1 431 ") || refused.is_empty(), "{refused}");
    assert!(answered(address, b"GET / HT").starts_with("HTTP/1.1 408 "), "half a request");

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

/// The command beside a cell: it says where the page is, and a port that is taken is one clear error.
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
        let said = page.stderr();
        address =
            said.lines().find_map(|line| line.strip_prefix("operator page: http://")?.strip_suffix('/')?.parse().ok());
        if address.is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    let address: SocketAddr = address.unwrap_or_else(|| panic!("it does not say where{}", page.complaint()));
    assert!(
        answered(address, format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes())
            .contains("<title>camwright cell")
    );
    let second = command(address.port()).output().expect("it starts");
    let said = String::from_utf8_lossy(&second.stderr);
    assert!(second.status.code() == Some(1) && said.contains("cannot be served at"), "{said}");
    page.interrupt();
    let status = page.wait(support::PATIENCE);
    assert!(status.success(), "{status}{}", page.complaint());
}
