//! The page's server: GET of three addresses, one thread for each connection, everything bounded.
//!
//! Nothing is looked up in a file system, so no path leads anywhere. A connection that does not say what it wants within its time or its
//! bytes is closed, and so is one too many; a viewer that does not read is left behind.

use super::feed::Feed;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Connections at the same time; a viewer holds one.
const MOST_CONNECTIONS: usize = 32;
/// Largest head of a request (bytes).
const MOST_HEAD: usize = 8192;
/// Most header lines of it.
const MOST_HEADERS: usize = 64;
/// How long a request may take to arrive, and an answer to be taken.
const PATIENCE: Duration = Duration::from_secs(3);
/// Time between two events at least: faster nobody reads.
const EVENT_PERIOD: Duration = Duration::from_millis(250);
/// Time between two events at most, so that a viewer knows that the page lives.
const HEARTBEAT: Duration = Duration::from_secs(1);

const PAGE: &str = include_str!("page.html");

/// Nothing comes from elsewhere, and nobody puts the page into theirs.
const COMMON: &str = "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
     Referrer-Policy: no-referrer\r\nContent-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; \
     script-src 'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\n";

/// A running server.
#[derive(Debug)]
pub(super) struct Server {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Takes the address and serves until it is stopped.
    pub(super) fn start(address: SocketAddr, feed: Arc<Feed>) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let stop = Arc::new(AtomicBool::new(false));
        let is_over = Arc::clone(&stop);
        let thread = std::thread::Builder::new().name("operator page".into()).spawn(move || {
            accept(&listener, address, &feed, &is_over);
        })?;
        Ok(Self { address, stop, thread: Some(thread) })
    }

    /// Where it listens.
    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Takes no more connections; those there are end with their next event.
    pub(super) fn stop(&mut self) {
        self.stop.store(true, Ordering::Release);
        // The thread sits in `accept`; a connection wakes it.
        let loopback = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => SocketAddr::from(([127, 0, 0, 1], self.address.port())),
            IpAddr::V6(ip) if ip.is_unspecified() => SocketAddr::from(([0, 0, 0, 0, 0, 0, 0, 1], self.address.port())),
            _ => self.address,
        };
        let _woken = TcpStream::connect_timeout(&loopback, PATIENCE);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has told so.
            let _panicked = thread.join();
        }
    }
}

fn accept(listener: &TcpListener, address: SocketAddr, feed: &Arc<Feed>, stop: &Arc<AtomicBool>) {
    let count = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        if stop.load(Ordering::Acquire) {
            return;
        }
        let Ok(mut stream) = stream else {
            // Out of descriptors, most likely: they come back.
            std::thread::sleep(EVENT_PERIOD);
            continue;
        };
        let seat = Seat::take(&count);
        if seat.is_none() {
            let _gone = stream.set_write_timeout(Some(EVENT_PERIOD));
            let _gone = refuse(&mut stream, "503 Service Unavailable", "too many viewers");
            continue;
        }
        let connection = Connection { stream, address, feed: Arc::clone(feed), stop: Arc::clone(stop), _seat: seat };
        let started = std::thread::Builder::new().name("page viewer".into()).spawn(move || connection.serve());
        // Without a thread the connection is closed, and the viewer asks again.
        drop(started);
    }
}

/// One of the places that connections may have.
#[derive(Debug)]
struct Seat(Arc<AtomicUsize>);

impl Seat {
    fn take(count: &Arc<AtomicUsize>) -> Option<Self> {
        if count.fetch_add(1, Ordering::AcqRel) < MOST_CONNECTIONS {
            return Some(Self(Arc::clone(count)));
        }
        count.fetch_sub(1, Ordering::AcqRel);
        None
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

struct Connection {
    stream: TcpStream,
    address: SocketAddr,
    feed: Arc<Feed>,
    stop: Arc<AtomicBool>,
    _seat: Option<Seat>,
}

/// What a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Page,
    Snapshot,
    Events,
}

/// Why it gets nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Refused(&'static str, &'static str);

impl Connection {
    fn serve(mut self) {
        // A viewer that went away is no failure of ours.
        let _gone = self.answer();
    }

    fn answer(&mut self) -> io::Result<()> {
        self.stream.set_nodelay(true)?;
        self.stream.set_write_timeout(Some(PATIENCE))?;
        let head = match read_head(&mut self.stream) {
            Ok(head) => head,
            Err(Refused(status, reason)) => return refuse(&mut self.stream, status, reason),
        };
        match wanted(&head, self.address.ip().is_loopback()) {
            Ok(Wanted::Page) => reply(&mut self.stream, "200 OK", "text/html; charset=utf-8", "", PAGE),
            Ok(Wanted::Snapshot) => {
                let body = self.feed.snapshot();
                reply(&mut self.stream, "200 OK", "application/json", "", &body)
            }
            Ok(Wanted::Events) => self.events(),
            Err(Refused(status, reason)) => refuse(&mut self.stream, status, reason),
        }
    }

    /// Server-sent events: `status` whenever something has changed and as a sign of life, `shape` when an outline has.
    fn events(&mut self) -> io::Result<()> {
        let head = format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{COMMON}\r\nretry: 1000\n\n");
        self.stream.write_all(head.as_bytes())?;
        let (mut seen, mut shape_seen) = (0, None);
        let mut told = Instant::now() - HEARTBEAT;
        while !self.stop.load(Ordering::Acquire) {
            let left = HEARTBEAT.saturating_sub(told.elapsed());
            seen = self.feed.wait_news(seen, left);
            let (status, shape) = self.feed.events(&mut shape_seen);
            let mut text = format!("event: status\ndata: {status}\n\n");
            if let Some(shape) = shape {
                text.push_str(&format!("event: shape\ndata: {shape}\n\n"));
            }
            self.stream.write_all(text.as_bytes())?;
            told = Instant::now();
            self.feed.pause(EVENT_PERIOD);
        }
        Ok(())
    }
}

/// Everything up to the empty line.
fn read_head(stream: &mut TcpStream) -> Result<Vec<u8>, Refused> {
    let too_late = Refused("408 Request Timeout", "the request did not come in time");
    let deadline = Instant::now() + PATIENCE;
    let mut head = Vec::with_capacity(1024);
    let mut chunk = [0; 1024];
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return Err(too_late);
        }
        match stream.read(&mut chunk) {
            Ok(0) => return Err(Refused("400 Bad Request", "the request has no end")),
            Ok(count) => head.extend_from_slice(&chunk[..count]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return Err(too_late),
        }
        if head.windows(4).any(|end| end == b"\r\n\r\n") {
            return Ok(head);
        }
        if head.len() > MOST_HEAD {
            return Err(Refused("431 Request Header Fields Too Large", "the request is too long"));
        }
    }
}

fn wanted(head: &[u8], on_loopback: bool) -> Result<Wanted, Refused> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        Ok(httparse::Status::Complete(_)) => {}
        Err(httparse::Error::TooManyHeaders) => {
            return Err(Refused("431 Request Header Fields Too Large", "the request has too many headers"));
        }
        _ => return Err(Refused("400 Bad Request", "this is no request")),
    }
    if request.method != Some("GET") {
        return Err(Refused("405 Method Not Allowed", "the page is to be looked at: GET only"));
    }
    // A page of another site whose name leads here shall not read the cell.
    let host = request.headers.iter().find(|header| header.name.eq_ignore_ascii_case("host"));
    let is_here = |host: &[u8]| {
        let host = std::str::from_utf8(host).unwrap_or_default();
        let name = host.rsplit_once(':').filter(|(_, port)| port.parse::<u16>().is_ok()).map_or(host, |(name, _)| name);
        ["localhost", "127.0.0.1", "[::1]"].contains(&name)
    };
    if on_loopback && !host.is_some_and(|host| is_here(host.value)) {
        return Err(Refused("403 Forbidden", "the page is served to this computer only"));
    }
    match request.path.unwrap_or_default() {
        "/" => Ok(Wanted::Page),
        "/snapshot.json" => Ok(Wanted::Snapshot),
        "/events" => Ok(Wanted::Events),
        _ => Err(Refused("404 Not Found", "there are /, /snapshot.json and /events")),
    }
}

fn refuse(stream: &mut TcpStream, status: &str, reason: &str) -> io::Result<()> {
    let allow = if status.starts_with("405") { "Allow: GET\r\n" } else { "" };
    reply(stream, status, "text/plain; charset=utf-8", allow, &format!("{reason}\n"))
}

fn reply(stream: &mut TcpStream, status: &str, kind: &str, more: &str, body: &str) -> io::Result<()> {
    let length = body.len();
    let head = format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{more}{COMMON}\r\n");
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(head: &str) -> Result<Wanted, &'static str> {
        wanted(head.as_bytes(), true).map_err(|refused| &refused.0[..3])
    }

    #[test]
    fn three_addresses_are_served_and_nothing_else() {
        let get = |path: &str| asked(&format!("GET {path} HTTP/1.1\r\nHost: localhost:8080\r\n\r\n"));
        assert_eq!(get("/"), Ok(Wanted::Page));
        assert_eq!(get("/snapshot.json"), Ok(Wanted::Snapshot));
        assert_eq!(get("/events"), Ok(Wanted::Events));
        for path in ["/../../etc/passwd", "/%2e%2e/etc/passwd", "/page.html", "//", "/?x", "/events/"] {
            assert_eq!(get(path), Err("404"), "{path}");
        }
        assert_eq!(asked("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n"), Err("405"));
        assert_eq!(asked("\u{1}\u{2}\r\n\r\n"), Err("400"));
        let many: String = (0..100).map(|i| format!("h{i}: x\r\n")).collect();
        assert_eq!(asked(&format!("GET / HTTP/1.1\r\nHost: localhost\r\n{many}\r\n")), Err("431"));
    }

    #[test]
    fn a_page_of_another_site_cannot_read_it_over_a_name_that_leads_here() {
        let host = |host: &str| asked(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        for here in ["localhost", "localhost:80", "127.0.0.1:8080", "[::1]:8080", "[::1]"] {
            assert_eq!(host(here), Ok(Wanted::Page), "{here}");
        }
        for elsewhere in ["evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.nip.io:80"] {
            assert_eq!(host(elsewhere), Err("403"), "{elsewhere}");
        }
        assert_eq!(asked("GET / HTTP/1.1\r\n\r\n"), Err("403"), "no host at all");
        assert!(wanted(b"GET / HTTP/1.1\r\nHost: cell.shop\r\n\r\n", false).is_ok(), "where it is served to others");
    }
}
