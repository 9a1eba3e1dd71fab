// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Server of the adapter: two threads for each client, everything bounded.
//!
//! A client sends nothing but `* PING`. Anything else ends its connection, as does a buffer that it does not read.

use crate::feed::ReadingFeed;
use crate::outbox::Outbox;
use crate::shdr::{HEARTBEAT_MS, pong};
use camwright_threads::supervised::Supervisor;
use camwright_threads::system_time::system_time_ns;
use camwright_threads::tcp_server::TcpServer;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Connections at the same time.
pub(super) const MAX_CLIENTS: usize = 16;
/// Time that a new client has for its first PING before another client may take its place. An agent sends it at once.
const FIRST_PING: Duration = Duration::from_secs(2);
/// Longest line of a client.
const MAX_LINE: usize = 64;
/// Maximum time of a write without progress.
const WRITE_PATIENCE: Duration = Duration::from_secs(5);

/// Number of clients so far, by how their connection went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClientCounts {
    /// Accepted connections.
    pub accepted: u64,
    /// Connections that were refused, or ended for a newer one, because there were too many.
    pub refused: u64,
    /// Clients that did not read.
    pub slow: u64,
    /// Clients whose PING did not come in time.
    pub silent: u64,
    /// Clients that sent something else than PING.
    pub rejected: u64,
}

#[derive(Debug, Default)]
struct Counters {
    accepted: AtomicU64,
    refused: AtomicU64,
    slow: AtomicU64,
    silent: AtomicU64,
    rejected: AtomicU64,
}

type Log = Box<dyn Fn(&str) + Send + Sync>;

/// State shared by all threads of the server.
#[derive(Default)]
struct Site {
    feed: Arc<ReadingFeed>,
    counters: Counters,
    clients: Mutex<Vec<Arc<Client>>>,
    is_stopped: Arc<AtomicBool>,
    /// Maximum time between two PINGs.
    silence: Duration,
    log: OnceLock<Log>,
}

/// A connection.
struct Client {
    outbox: Arc<Outbox>,
    from: SocketAddr,
    since: Instant,
    has_pinged: AtomicBool,
    /// Its end was reported.
    has_ended: AtomicBool,
}

pub(super) struct AdapterServer {
    connections: TcpServer,
    site: Arc<Site>,
}

impl std::fmt::Debug for AdapterServer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("AdapterServer").field("connections", &self.connections).finish_non_exhaustive()
    }
}

/// Reason for the end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Gone,
    Silent,
    Rejected(&'static str),
}

impl AdapterServer {
    /// Binds the address and serves the feed until it is stopped.
    pub(super) fn start(address: SocketAddr, feed: Arc<ReadingFeed>, supervisor: &Supervisor) -> io::Result<Self> {
        Self::start_with(address, feed, Duration::from_millis(2 * u64::from(HEARTBEAT_MS)), supervisor)
    }

    fn start_with(
        address: SocketAddr,
        feed: Arc<ReadingFeed>,
        silence: Duration,
        supervisor: &Supervisor,
    ) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let site = Arc::new(Site { feed, silence, ..Site::default() });
        let (shared, client_threads) = (Arc::clone(&site), supervisor.clone());
        let is_stopped = Arc::clone(&site.is_stopped);
        let connections = TcpServer::start(listener, ("plant gateway", supervisor), is_stopped, move |stream| {
            serve(&shared, stream, &client_threads);
        })?;
        Ok(Self { connections, site })
    }

    /// Reports ends of connections that are no ordinary ones.
    pub(super) fn set_log(&self, log: impl Fn(&str) + Send + Sync + 'static) {
        let _already_set = self.site.log.set(Box::new(log));
    }

    pub(super) fn address(&self) -> SocketAddr {
        self.connections.address()
    }

    pub(super) fn statistics(&self) -> ClientCounts {
        let Counters { accepted, refused, slow, silent, rejected } = &self.site.counters;
        let count = |counter: &AtomicU64| counter.load(Ordering::Acquire);
        ClientCounts {
            accepted: count(accepted),
            refused: count(refused),
            slow: count(slow),
            silent: count(silent),
            rejected: count(rejected),
        }
    }

    /// Ends all connections.
    pub(super) fn stop(&mut self) {
        self.connections.stop();
        self.site.clients().drain(..).for_each(|client| client.outbox.close());
    }
}

impl Site {
    fn clients(&self) -> MutexGuard<'_, Vec<Arc<Client>>> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn report(&self, counter: &AtomicU64, from: SocketAddr, what: &str) {
        let count = counter.fetch_add(1, Ordering::AcqRel) + 1;
        if let Some(log) = self.log.get() {
            log(&format!("MTConnect client {from} {what} ({count} so far)"));
        }
    }

    /// Makes a client of a connection. If all places are taken, it gets that of the oldest one that never sent PING.
    fn admit(&self, stream: TcpStream) -> Option<Arc<Client>> {
        let from = stream.peer_addr().ok()?;
        let mut clients = self.clients();
        if clients.len() >= MAX_CLIENTS {
            let is_idle = |client: &&Arc<Client>| {
                !client.has_pinged.load(Ordering::Acquire) && client.since.elapsed() >= FIRST_PING
            };
            let oldest = clients.iter().filter(is_idle).min_by_key(|client| client.since).cloned();
            let left = oldest.as_ref().map_or(from, |client| client.from);
            self.report(&self.counters.refused, left, "is disconnected: there are too many clients");
            let oldest = oldest?;
            oldest.has_ended.store(true, Ordering::Release);
            oldest.outbox.close();
            clients.retain(|client| !Arc::ptr_eq(client, &oldest));
        }
        let client = Arc::new(Client {
            outbox: Arc::new(Outbox::new(stream)),
            from,
            since: Instant::now(),
            has_pinged: AtomicBool::new(false),
            has_ended: AtomicBool::new(false),
        });
        clients.push(Arc::clone(&client));
        Some(client)
    }

    /// Ends a connection and reports its reason once.
    fn end(&self, client: &Arc<Client>, end: End) {
        let is_first = !client.has_ended.swap(true, Ordering::AcqRel);
        let has_overflowed = client.outbox.has_overflowed();
        client.outbox.close();
        self.clients().retain(|other| !Arc::ptr_eq(other, client));
        if !is_first || self.is_stopped.load(Ordering::Acquire) {
            return;
        }
        let Counters { slow, silent, rejected, .. } = &self.counters;
        match end {
            _ if has_overflowed => self.report(slow, client.from, "does not read and is disconnected"),
            End::Gone => {}
            End::Silent => self.report(silent, client.from, "sends no PING any more and is disconnected"),
            End::Rejected(why) => self.report(rejected, client.from, &format!("is disconnected: {why}")),
        }
    }
}

/// Makes a client of a connection.
fn serve(site: &Arc<Site>, stream: TcpStream, supervisor: &Supervisor) {
    let Some(client) = site.admit(stream) else { return };
    site.counters.accepted.fetch_add(1, Ordering::AcqRel);
    if start(site, &client, supervisor).is_err() {
        // Without threads the connection is closed, and the agent asks again.
        site.end(&client, End::Gone);
    }
}

/// Starts the threads of a client.
fn start(site: &Arc<Site>, client: &Arc<Client>, supervisor: &Supervisor) -> io::Result<()> {
    let stream = client.outbox.stream();
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_PATIENCE))?;
    site.feed.join(Arc::clone(&client.outbox), system_time_ns());
    for (name, work) in [("gateway writer", write as fn(&Client, Duration) -> End), ("gateway reader", read)] {
        let (site, client) = (Arc::clone(site), Arc::clone(client));
        drop(supervisor.spawn(name, move || {
            let end = work(&client, site.silence);
            site.end(&client, end);
        })?);
    }
    Ok(())
}

/// Writes what the feed has for a client until the connection ends.
fn write(client: &Client, _: Duration) -> End {
    let mut stream = client.outbox.stream();
    while let Some(bytes) = client.outbox.take() {
        match stream.write_all(&bytes) {
            Ok(()) => {}
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                client.outbox.mark_overflowed();
                return End::Gone;
            }
            Err(_) => return End::Gone,
        }
    }
    End::Gone
}

/// Answers PING until the connection ends.
fn read(client: &Client, silence: Duration) -> End {
    let mut stream = client.outbox.stream();
    let (mut line, mut chunk) = (Vec::with_capacity(MAX_LINE), [0; 256]);
    // A client that never sends PING may listen as long as it likes.
    let mut deadline = None::<Instant>;
    loop {
        let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
        if left.is_some_and(|left| left.is_zero()) {
            return End::Silent;
        }
        if stream.set_read_timeout(left).is_err() {
            return End::Gone;
        }
        let count = match stream.read(&mut chunk) {
            Ok(0) => return End::Gone,
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => continue,
            Err(_) => return End::Gone,
        };
        for byte in &chunk[..count] {
            if *byte != b'\n' {
                if line.len() == MAX_LINE {
                    return End::Rejected("its line is too long; only PING is accepted");
                }
                line.push(*byte);
                continue;
            }
            match line.trim_ascii() {
                b"" => {}
                b"* PING" => {
                    client.has_pinged.store(true, Ordering::Release);
                    deadline = Some(Instant::now() + silence);
                    client.outbox.push(pong().as_bytes());
                }
                _ => return End::Rejected("only PING is accepted"),
            }
            line.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_messages::{CellMessages, Presence};
    use crate::items::read_all;
    use camwright_msgs::camwright_msgs::msg::CellState;
    use std::io::{BufRead, BufReader};
    use std::net::Ipv4Addr;

    const PATIENCE: Duration = Duration::from_secs(60);

    /// A cell whose job has a name.
    fn cell(job: &str) -> CellMessages {
        CellMessages {
            presence: Presence { machine: true, interpolator: true, planner: true },
            cell: Some(CellState { job: job.into(), ..CellState::default() }),
            ..CellMessages::default()
        }
    }

    fn server(silence: Duration) -> (AdapterServer, Arc<ReadingFeed>) {
        let feed = Arc::new(ReadingFeed::new(read_all(&CellMessages::default())));
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let server = AdapterServer::start_with(address, Arc::clone(&feed), silence, &Supervisor::default());
        (server.expect("a server"), feed)
    }

    fn connect(server: &AdapterServer) -> BufReader<TcpStream> {
        let stream = TcpStream::connect(server.address()).expect("the server listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a limit");
        BufReader::new(stream)
    }

    /// Next line, empty at the end of the connection.
    fn line(client: &mut BufReader<TcpStream>) -> String {
        let mut line = String::new();
        match client.read_line(&mut line) {
            Ok(_) => line,
            // The server closed the connection with bytes of ours unread.
            Err(error) if error.kind() == ErrorKind::ConnectionReset => String::new(),
            Err(error) => panic!("{error} after {line}"),
        }
    }

    /// Greeting and the first values.
    fn skip_first(client: &mut BufReader<TcpStream>) -> Vec<String> {
        (0..8).map(|_| line(client)).collect()
    }

    fn send(client: &BufReader<TcpStream>, text: &str) {
        client.get_ref().write_all(text.as_bytes()).expect("a connection");
    }

    fn is_at_end(client: &mut BufReader<TcpStream>) -> bool {
        while !line(client).is_empty() {}
        true
    }

    /// Waits for a count of the statistics.
    fn wait_for(server: &AdapterServer, wanted: impl Fn(ClientCounts) -> bool) -> ClientCounts {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let now = server.statistics();
            if wanted(now) {
                return now;
            }
            assert!(Instant::now() < deadline, "{now:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn an_agent_gets_everything_once_then_changes_and_pongs() {
        let (mut server, feed) = server(PATIENCE);
        let mut agent = connect(&server);
        send(&agent, "* PING\n");
        let first = skip_first(&mut agent);
        assert!(first[0].starts_with("* adapterVersion: ") && first[2] == "* shdrVersion: 2\n", "{first:?}");
        assert!(first[3].contains("|availability|UNAVAILABLE|"), "{first:?}");
        assert_eq!(line(&mut agent), "* PONG 10000\n");
        feed.publish(read_all(&cell("eccentric")), false, 0);
        let change = line(&mut agent);
        assert!(change.contains("|availability|AVAILABLE") && change.contains("|program|eccentric"), "{change}");
        // The second client begins with the present values, and both get what follows.
        let mut second = connect(&server);
        assert!(skip_first(&mut second)[3].contains("|program|eccentric|"));
        feed.publish(read_all(&cell("disc")), false, 0);
        for client in [&mut agent, &mut second] {
            assert_eq!(line(client), "1970-01-01T00:00:00.000Z|program|disc\n");
        }
        send(&agent, "\r\n* PING\r\n");
        assert_eq!(line(&mut agent), "* PONG 10000\n");
        assert_eq!(server.statistics(), ClientCounts { accepted: 2, ..ClientCounts::default() });
        server.stop();
        assert!(is_at_end(&mut agent) && is_at_end(&mut second));
    }

    #[test]
    fn a_client_that_never_reads_is_disconnected_and_disturbs_no_other() {
        let (mut server, feed) = server(PATIENCE);
        let sleeper = connect(&server);
        let mut agent = connect(&server);
        skip_first(&mut agent);
        wait_for(&server, |now| now.accepted == 2);
        let mut count = 0_usize;
        while server.statistics().slow == 0 {
            count += 1;
            // More than the sockets of both sides hold.
            assert!(count < 100_000, "100 MB are kept for a client that does not read");
            let job = format!("{count}{}", "x".repeat(1000));
            feed.publish(read_all(&cell(&job)), false, 0);
            assert!(line(&mut agent).contains(&job), "every change arrives");
        }
        assert_eq!(server.statistics().slow, 1);
        feed.publish(read_all(&cell("the last one")), false, 0);
        assert!(line(&mut agent).ends_with("|program|the last one\n"));
        drop(sleeper);
        server.stop();
    }

    #[test]
    fn whoever_sends_something_else_than_ping_is_disconnected() {
        let (mut server, feed) = server(PATIENCE);
        let mut agent = connect(&server);
        skip_first(&mut agent);
        let long = "* PING ".repeat(20);
        let hostile = ["GET / HTTP/1.1\r\n\r\n", "* device: other\n", "\u{0}\u{1}\n", &long, "2026|program|x\n"];
        for (index, text) in hostile.iter().enumerate() {
            let mut client = connect(&server);
            send(&client, text);
            assert!(is_at_end(&mut client), "{text:?}");
            wait_for(&server, |now| now.rejected == index as u64 + 1);
        }
        // A line without end.
        let endless = connect(&server);
        let block = [b'x'; 4096];
        while endless.get_ref().write_all(&block).is_ok() {}
        wait_for(&server, |now| now.rejected == hostile.len() as u64 + 1);
        feed.publish(read_all(&cell("disc")), false, 0);
        assert!(line(&mut agent).contains("|program|disc"), "the agent is not disturbed");
        server.stop();
    }

    #[test]
    fn a_hundred_connections_are_bounded_and_keep_no_place_from_an_agent() {
        let (mut server, feed) = server(PATIENCE);
        let mut agent = connect(&server);
        send(&agent, "* PING\n");
        skip_first(&mut agent);
        assert_eq!(line(&mut agent), "* PONG 10000\n");
        let silent: Vec<_> = (0..100).map(|_| connect(&server)).collect();
        wait_for(&server, |now| now.refused >= 85);
        assert_eq!(server.site.clients().len(), MAX_CLIENTS);
        // Two seconds later the next one gets the place of one of them; the first agent keeps its own.
        let deadline = Instant::now() + PATIENCE;
        let mut late = loop {
            let mut late = connect(&server);
            if !line(&mut late).is_empty() {
                break late;
            }
            assert!(Instant::now() < deadline, "{:?}", server.statistics());
            std::thread::sleep(Duration::from_millis(100));
        };
        (0..7).for_each(|_| drop(line(&mut late)));
        feed.publish(read_all(&cell("disc")), false, 0);
        for client in [&mut agent, &mut late] {
            assert!(line(client).contains("|program|disc"));
        }
        drop(silent);
        server.stop();
    }

    #[test]
    fn an_agent_whose_pings_end_is_disconnected_and_a_listener_stays() {
        let (mut server, feed) = server(Duration::from_millis(200));
        let mut listener = connect(&server);
        skip_first(&mut listener);
        let mut agent = connect(&server);
        send(&agent, "* PING\n");
        assert!(is_at_end(&mut agent));
        assert_eq!(wait_for(&server, |now| now.silent > 0).silent, 1);
        feed.publish(read_all(&cell("disc")), false, 0);
        assert!(line(&mut listener).contains("|program|disc"));
        server.stop();
    }
}
