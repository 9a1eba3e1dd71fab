// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A real browser without a window: Chromium over its debugging pipe, so that no port and no driver is needed.
#![allow(missing_debug_implementations, reason = "a helper of tests")]
#![allow(unreachable_pub, reason = "a module of a test binary has no outside")]

use crate::support::{Folder, PATIENCE, in_ci};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Part of the patience in which the browser reports that something did not become true.
const ANSWER: Duration = Duration::from_secs(10);

/// A browser with one page; killed when this is dropped.
pub struct Chromium {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    next: u64,
    session: String,
    _profile: Folder,
}

impl Drop for Chromium {
    fn drop(&mut self) {
        // It ends its own children when it is asked to; the profile goes after it.
        let asked = writeln_zero(&mut self.to, &json!({ "id": 0, "method": "Browser.close" }));
        let deadline = Instant::now() + PATIENCE;
        while asked && matches!(self.child.try_wait(), Ok(None)) && Instant::now() < deadline {
            let _closed = self.from.recv_timeout(Duration::from_millis(50));
        }
        let _gone_already = self.child.kill();
        let _reaped = self.child.wait();
    }
}

fn writeln_zero(to: &mut ChildStdin, value: &Value) -> bool {
    let mut bytes = value.to_string().into_bytes();
    bytes.push(0);
    to.write_all(&bytes).and_then(|()| to.flush()).is_ok()
}

impl Chromium {
    /// The browser of the search path on an empty page; `None`, loudly, where there is none.
    ///
    /// # Panics
    /// When there is none under `CI=true`, or it does not start.
    pub fn start(width: u32, height: u32) -> Option<Self> {
        let Some(program) = find() else {
            assert!(!in_ci(), "chromium is not there: the tests with a browser are not optional in CI");
            let test = std::thread::current().name().map(str::to_owned);
            eprintln!("SKIPPED, NOT PASSED: chromium is not there, no browser has looked (test {test:?})");
            return None;
        };
        // One profile for each browser: a second one on the same profile ends at once.
        static STARTED: AtomicU32 = AtomicU32::new(0);
        let profile = Folder::new(&format!("chromium-{}", STARTED.fetch_add(1, Ordering::Relaxed)));
        // It reads orders from descriptor 3 and answers on 4.
        let mut command = Command::new("sh");
        command
            .args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", "sh"])
            .arg(program)
            .args(["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu", "--no-first-run"])
            .args(["--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update"])
            .args([
                "--disable-sync",
                "--disable-extensions",
                "--hide-scrollbars",
                "--lang=en",
                "--force-color-profile=srgb",
            ])
            // Nothing but this computer is there for it.
            .arg("--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE localhost , EXCLUDE 127.0.0.1")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut child = command.spawn().expect("sh starts");
        let (to, stdout) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
        let (send, from) = channel();
        std::thread::spawn(move || {
            let mut reader = BufReader::new(stdout);
            let mut bytes = Vec::new();
            while matches!(reader.read_until(0, &mut bytes), Ok(1..)) {
                bytes.pop();
                let is_sent = serde_json::from_slice(&bytes).is_ok_and(|value: Value| send.send(value).is_ok());
                bytes.clear();
                if !is_sent {
                    break;
                }
            }
        });
        let mut browser = Self { child, to, from, next: 0, session: String::new(), _profile: profile };
        let target = browser.ask("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].take();
        let attached = browser.ask("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        attached["sessionId"].as_str().expect("a session").clone_into(&mut browser.session);
        browser.resize(width, height);
        Some(browser)
    }

    /// An order and its answer.
    ///
    /// # Panics
    /// When the browser refuses, or does not answer.
    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        self.next += 1;
        let mut order = json!({ "id": self.next, "method": method, "params": params });
        if !self.session.is_empty() {
            order["sessionId"] = json!(self.session);
        }
        assert!(writeln_zero(&mut self.to, &order), "the browser has ended");
        let deadline = Instant::now() + PATIENCE;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let mut is_sent = self.from.recv_timeout(left).unwrap_or_else(|_| panic!("no answer to {method} {order}"));
            if is_sent["id"] == self.next {
                assert!(is_sent.get("error").is_none(), "{method}: {}", is_sent["error"]);
                return is_sent["result"].take();
            }
        }
    }

    /// Another size of the page.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.ask("Emulation.setDeviceMetricsOverride", size);
    }

    /// Sets the colour scheme: `light` or `dark`.
    pub fn set_color_scheme(&mut self, scheme: &str) {
        let features = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        self.ask("Emulation.setEmulatedMedia", features);
    }

    /// Opens an address and waits for the page.
    pub fn open(&mut self, address: &str) {
        let answer = self.ask("Page.navigate", json!({ "url": address }));
        assert!(answer.get("errorText").is_none(), "{address}: {answer}");
        self.wait("document.readyState === 'complete' && location.href !== 'about:blank'");
    }

    /// Value of an expression in the page.
    pub fn eval(&mut self, expression: &str) -> Value {
        let order = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.ask("Runtime.evaluate", order);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true: it is looked at again with every change of the page.
    ///
    /// # Panics
    /// When it does not become true, with the last status that the page has received.
    pub fn wait(&mut self, claim: &str) {
        let limit_ms = (PATIENCE - ANSWER).as_millis();
        let promise = format!(
            "new Promise(done => {{ const look = () => {{ if ({claim}) {{ done(true); return true; }} }}; if (look()) return; \
             const watch = new MutationObserver(() => look() && watch.disconnect()); \
             watch.observe(document, {{ subtree: true, childList: true, characterData: true, attributes: true }}); \
             addEventListener('load', look); setTimeout(() => done(false), {limit_ms}); }})"
        );
        if self.eval(&promise) != true {
            let seen = self.eval(
                "JSON.stringify([typeof status === 'object' ? status : document.body.innerText, \
                 typeof shape === 'object' ? [shape.part?.name, shape.designs[0]?.error_um.length] : null])",
            );
            panic!("{claim}: not within {limit_ms} ms; the page shows {seen}");
        }
    }

    /// Picture as PNG of the window or of the whole page.
    pub fn picture(&mut self, whole_page: bool) -> Vec<u8> {
        let order = json!({ "format": "png", "captureBeyondViewport": whole_page });
        base64(self.ask("Page.captureScreenshot", order)["data"].as_str().expect("a picture"))
    }
}

fn find() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let named = ["chromium", "chromium-browser", "google-chrome"];
    named.iter().find_map(|name| folders.iter().map(|folder| folder.join(name)).find(|program| program.is_file()))
}

fn base64(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => u32::from(c - b'A'),
        b'a'..=b'z' => u32::from(c - b'a') + 26,
        b'0'..=b'9' => u32::from(c - b'0') + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u8> = text.bytes().filter(|c| *c != b'=').collect();
    let mut bytes = Vec::with_capacity(digits.len() * 3 / 4);
    for group in digits.chunks(4) {
        let bits = group.iter().enumerate().fold(0, |bits, (i, c)| bits | value(*c) << (18 - 6 * i));
        bytes.extend(&bits.to_be_bytes()[1..group.len()]);
    }
    bytes
}
