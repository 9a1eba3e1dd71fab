// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Server of the page: three addresses to read and, with control, three to operate; one thread per connection, everything bounded.
//!
//! Paths are compared, never looked up in a file system. A connection without a complete request within its time and size is closed. A
//! viewer that does not read loses its slot to the next one.

use super::control::Control;
use super::feed::Feed;
use super::operation::{Answer, Operation};
use super::viewers::{ViewerSlot, Viewers};
use camwright_threads::supervised::Supervisor;
use camwright_threads::tcp_server::TcpServer;
use std::io::{self, ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Largest head of a request (bytes).
const MAX_HEAD: usize = 8192;
/// Largest body of a request (bytes).
const MAX_BODY: usize = 1024;
/// Maximum number of header lines.
const MAX_HEADERS: usize = 64;
/// Maximum time for receiving a request, and for sending an answer.
const PATIENCE: Duration = Duration::from_secs(3);
/// Minimum time between two events.
const EVENT_PERIOD: Duration = Duration::from_millis(250);
/// Maximum time between two events, as a sign of life.
const HEARTBEAT: Duration = Duration::from_secs(1);

const PAGE: &str = include_str!("page.html");

/// Headers of every answer: the page loads nothing from elsewhere, and no other site embeds it.
const COMMON: &str = "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
     Referrer-Policy: no-referrer\r\nContent-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; \
     script-src 'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\n";

#[derive(Debug)]
pub(super) struct Server {
    connections: TcpServer,
    control: Arc<OnceLock<Control>>,
}

/// State shared by all connections.
#[derive(Debug, Clone)]
struct Site {
    address: SocketAddr,
    feed: Arc<Feed>,
    stop: Arc<AtomicBool>,
    control: Arc<OnceLock<Control>>,
}

impl Server {
    /// Binds the address and serves until it is stopped.
    pub(super) fn start(address: SocketAddr, feed: Arc<Feed>, supervisor: &Supervisor) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let stop = Arc::new(AtomicBool::new(false));
        let control = Arc::new(OnceLock::new());
        let site = Site { address, feed, stop: Arc::clone(&stop), control: Arc::clone(&control) };
        let (viewers, viewer_threads) = (Viewers::default(), supervisor.clone());
        let connections = TcpServer::start(listener, ("operator page", supervisor), stop, move |stream| {
            // Without a slot the connection is closed at once: those that were shut down have not ended yet.
            let Some(slot) = viewers.occupy(&stream) else { return };
            let connection = Connection { stream, site: site.clone(), slot };
            let started = viewer_threads.spawn("page viewer", move || connection.serve());
            // Without a thread the connection is closed, and the viewer asks again.
            drop(started);
        })?;
        Ok(Self { connections, control })
    }

    /// Lets viewers with the token operate the cell.
    pub(super) fn set_control(&self, control: Control) {
        let _already_set = self.control.set(control);
    }

    pub(super) fn address(&self) -> SocketAddr {
        self.connections.address()
    }

    /// Takes no more connections; those there are end with their next event.
    pub(super) fn stop(&mut self) {
        self.connections.stop();
    }
}

struct Connection {
    stream: TcpStream,
    site: Site,
    slot: ViewerSlot,
}

/// Requested resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Resource {
    Page,
    Snapshot,
    Events,
    /// Performs the operation of the body.
    Operate,
    /// Sign of life of a held jog button.
    Hold,
    /// Release of a jog button.
    Release,
}

/// Head of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct RequestHead<'a> {
    resource: Resource,
    token: Option<&'a [u8]>,
    body_length: usize,
}

/// Status and reason of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Refused(&'static str, &'static str);

impl Connection {
    fn serve(mut self) {
        // The viewer may have gone.
        let _gone = self.answer();
    }

    fn answer(&mut self) -> io::Result<()> {
        self.stream.set_nodelay(true)?;
        let (head, rest) = match read_head(&mut self.stream) {
            Ok(read) => read,
            Err(Refused(status, reason)) => return self.refuse(status, reason),
        };
        self.slot.mark_requested();
        let request = match parse_head(&head, self.site.address.ip().is_loopback()) {
            Ok(request) => request,
            Err(Refused(status, reason)) => return self.refuse(status, reason),
        };
        match request.resource {
            Resource::Page => self.reply("200 OK", "text/html; charset=utf-8", "", PAGE),
            Resource::Snapshot => {
                let body = self.site.feed.snapshot();
                self.reply("200 OK", "application/json", "", &body)
            }
            Resource::Events => self.events(),
            Resource::Operate | Resource::Hold | Resource::Release => match self.operate(request, rest) {
                Ok(answer) => {
                    let body = serde_json::to_string(&answer).map_err(io::Error::other)?;
                    self.reply("200 OK", "application/json", "", &body)
                }
                Err(Refused(status, reason)) => self.refuse(status, reason),
            },
        }
    }

    /// Operates the cell for a viewer that presents the token.
    fn operate(&mut self, request: RequestHead<'_>, rest: Vec<u8>) -> Result<Answer, Refused> {
        let site = self.site.clone();
        let no_control = Refused("403 Forbidden", "start the page with --control, and open the address that it prints");
        let control = site.control.get().ok_or(no_control)?;
        if !request.token.is_some_and(|token| control.admits(token)) {
            return Err(Refused(
                "403 Forbidden",
                "the token is wrong; open the address that the page printed at its start",
            ));
        }
        let body = read_body(&mut self.stream, rest, request.body_length)?;
        match request.resource {
            Resource::Hold => control.hold(),
            Resource::Release => control.release(),
            _ => {
                let operation = serde_json::from_slice::<Operation>(&body)
                    .map_err(|_| Refused("400 Bad Request", "the body is not a known operation"))?;
                return Ok(control.perform(&operation));
            }
        }
        Ok(Answer { done: true, message: String::new() })
    }

    /// Server-sent events: `status` whenever something has changed and as a sign of life, `shape` when an outline has.
    fn events(&mut self) -> io::Result<()> {
        let head = format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{COMMON}\r\nretry: 1000\n\n");
        self.slot.write(&self.stream, head.as_bytes(), PATIENCE)?;
        let (mut seen, mut shape_seen) = (0, None);
        let mut sent = Instant::now() - HEARTBEAT;
        while !self.site.stop.load(Ordering::Acquire) {
            let left = HEARTBEAT.saturating_sub(sent.elapsed());
            seen = self.site.feed.wait_newer(seen, left);
            let (status, shape) = self.site.feed.events(&mut shape_seen);
            let mut text = format!("event: status\ndata: {status}\n\n");
            if let Some(shape) = shape {
                text.push_str(&format!("event: shape\ndata: {shape}\n\n"));
            }
            self.slot.write(&self.stream, text.as_bytes(), PATIENCE)?;
            sent = Instant::now();
            self.site.feed.pause(EVENT_PERIOD);
        }
        Ok(())
    }

    fn refuse(&self, status: &str, reason: &str) -> io::Result<()> {
        let allow = if status.starts_with("405") { "Allow: GET, POST\r\n" } else { "" };
        self.reply(status, "text/plain; charset=utf-8", allow, &format!("{reason}\n"))
    }

    fn reply(&self, status: &str, kind: &str, more: &str, body: &str) -> io::Result<()> {
        let length = body.len();
        let head =
            format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{more}{COMMON}\r\n");
        self.slot.write(&self.stream, [head.as_bytes(), body.as_bytes()].concat().as_slice(), PATIENCE)
    }
}

/// Reads up to the empty line; returns the head, and what arrived of the body.
fn read_head(stream: &mut TcpStream) -> Result<(Vec<u8>, Vec<u8>), Refused> {
    let mut head = Vec::with_capacity(1024);
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(end) = head.windows(4).position(|end| end == b"\r\n\r\n") {
            let rest = head.split_off(end + 4);
            return Ok((head, rest));
        }
        if head.len() > MAX_HEAD {
            return Err(Refused("431 Request Header Fields Too Large", "the request is too long"));
        }
        read_more(stream, &mut head, deadline)?;
    }
}

/// Reads the rest of a body.
fn read_body(stream: &mut TcpStream, mut body: Vec<u8>, length: usize) -> Result<Vec<u8>, Refused> {
    let deadline = Instant::now() + PATIENCE;
    while body.len() < length {
        read_more(stream, &mut body, deadline)?;
    }
    body.truncate(length);
    Ok(body)
}

fn read_more(stream: &mut TcpStream, into: &mut Vec<u8>, deadline: Instant) -> Result<(), Refused> {
    let too_late = Refused("408 Request Timeout", "the request did not arrive in time");
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
        return Err(too_late);
    }
    let mut chunk = [0; 1024];
    match stream.read(&mut chunk) {
        Ok(0) => Err(Refused("400 Bad Request", "the request has no end")),
        Ok(count) => {
            into.extend_from_slice(&chunk[..count]);
            Ok(())
        }
        Err(error) if error.kind() == ErrorKind::Interrupted => Ok(()),
        Err(_) => Err(too_late),
    }
}

fn parse_head(head: &[u8], on_loopback: bool) -> Result<RequestHead<'_>, Refused> {
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        Ok(httparse::Status::Complete(_)) => {}
        Err(httparse::Error::TooManyHeaders) => {
            return Err(Refused("431 Request Header Fields Too Large", "the request has too many headers"));
        }
        _ => return Err(Refused("400 Bad Request", "malformed request")),
    }
    let header = |name: &str| {
        let found = request.headers.iter().find(|header| header.name.eq_ignore_ascii_case(name));
        found.map(|header| header.value)
    };
    // A page of another site whose name leads here must not read the cell.
    let is_here = |host: &[u8]| {
        let host = std::str::from_utf8(host).unwrap_or_default();
        let name = host.rsplit_once(':').filter(|(_, port)| port.parse::<u16>().is_ok()).map_or(host, |(name, _)| name);
        ["localhost", "127.0.0.1", "[::1]"].contains(&name)
    };
    if on_loopback && !header("host").is_some_and(is_here) {
        return Err(Refused("403 Forbidden", "the page is served to this computer only"));
    }
    let length = header("content-length").map_or(Some(0), |text| std::str::from_utf8(text).ok()?.trim().parse().ok());
    let resource = match (request.method, request.path.unwrap_or_default()) {
        (Some("GET"), "/") => Resource::Page,
        (Some("GET"), "/snapshot.json") => Resource::Snapshot,
        (Some("GET"), "/events") => Resource::Events,
        (Some("POST"), "/operate") => Resource::Operate,
        (Some("POST"), "/hold-to-run") => Resource::Hold,
        (Some("POST"), "/release") => Resource::Release,
        (Some("GET"), _) => return Err(Refused("404 Not Found", "known addresses are /, /snapshot.json and /events")),
        _ => {
            return Err(Refused(
                "405 Method Not Allowed",
                "GET reads; POST operates at /operate, /hold-to-run and /release",
            ));
        }
    };
    match length {
        Some(body_length) if body_length <= MAX_BODY => {
            Ok(RequestHead { resource, token: header("x-camwright-token"), body_length })
        }
        _ => Err(Refused("413 Content Too Large", "a body has at most 1024 bytes")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::viewers::MAX_VIEWERS;
    use super::*;
    use std::io::Write;
    use std::net::Ipv4Addr;

    fn get(address: SocketAddr, path: &str) -> TcpStream {
        let mut stream = TcpStream::connect(address).expect("the server listens");
        let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("a request");
        stream
    }

    /// The first bytes of an answer.
    fn status_line(mut stream: &TcpStream) -> String {
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a limit");
        let mut bytes = [0; 15];
        match stream.read_exact(&mut bytes) {
            Ok(()) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn viewers_that_do_not_read_or_ask_keep_no_slot_from_a_new_one() {
        let server = Server::start(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)), Arc::default(), &Supervisor::default());
        let mut server = server.expect("a server");
        // Half of them do not even ask; none reads.
        let silent: Vec<TcpStream> = (0..MAX_VIEWERS + 8)
            .map(|viewer| match viewer % 2 {
                0 => get(server.address(), "/events"),
                _ => TcpStream::connect(server.address()).expect("the server listens"),
            })
            .collect();
        for path in ["/", "/snapshot.json", "/events"] {
            assert_eq!(status_line(&get(server.address(), path)), "HTTP/1.1 200 OK", "{path}");
        }
        // A viewer that reads stays while others come and go.
        let viewer = get(server.address(), "/events");
        assert_eq!(status_line(&viewer), "HTTP/1.1 200 OK");
        for _ in 0..MAX_VIEWERS / 2 {
            assert_eq!(status_line(&get(server.address(), "/")), "HTTP/1.1 200 OK");
        }
        let mut lines = String::new();
        while !lines.contains("event: status") {
            let mut bytes = [0; 64];
            let count = (&viewer).read(&mut bytes).expect("it is still served");
            assert!(count > 0, "it was shut down");
            lines.push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
        server.stop();
        drop(silent);
    }

    fn resource_of(head: &str) -> Result<Resource, &'static str> {
        parse_head(head.as_bytes(), true).map(|request| request.resource).map_err(|refused| &refused.0[..3])
    }

    #[test]
    fn six_addresses_are_served_and_nothing_else() {
        let get = |path: &str| resource_of(&format!("GET {path} HTTP/1.1\r\nHost: localhost:8080\r\n\r\n"));
        assert_eq!(get("/"), Ok(Resource::Page));
        assert_eq!(get("/snapshot.json"), Ok(Resource::Snapshot));
        assert_eq!(get("/events"), Ok(Resource::Events));
        for path in ["/../../etc/passwd", "/%2e%2e/etc/passwd", "/page.html", "//", "/?x", "/events/"] {
            assert_eq!(get(path), Err("404"), "{path}");
        }
        assert_eq!(resource_of("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n"), Err("405"));
        assert_eq!(resource_of("POST /operate HTTP/1.1\r\nHost: localhost\r\n\r\n"), Ok(Resource::Operate));
        let long = "POST /operate HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1025\r\n\r\n";
        assert_eq!(resource_of(long), Err("413"));
        assert_eq!(resource_of("\u{1}\u{2}\r\n\r\n"), Err("400"));
        let many: String = (0..100).map(|i| format!("h{i}: x\r\n")).collect();
        assert_eq!(resource_of(&format!("GET / HTTP/1.1\r\nHost: localhost\r\n{many}\r\n")), Err("431"));
    }

    #[test]
    fn a_page_of_another_site_cannot_read_it_over_a_name_that_leads_here() {
        let host = |host: &str| resource_of(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        for here in ["localhost", "localhost:80", "127.0.0.1:8080", "[::1]:8080", "[::1]"] {
            assert_eq!(host(here), Ok(Resource::Page), "{here}");
        }
        for elsewhere in ["evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.nip.io:80"] {
            assert_eq!(host(elsewhere), Err("403"), "{elsewhere}");
        }
        assert_eq!(resource_of("GET / HTTP/1.1\r\n\r\n"), Err("403"), "no host at all");
        assert!(
            parse_head(b"GET / HTTP/1.1\r\nHost: cell.shop\r\n\r\n", false).is_ok(),
            "where it is served to others"
        );
    }
}
