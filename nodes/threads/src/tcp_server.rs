// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A thread that accepts TCP connections until it is stopped.

use crate::supervised::{Supervisor, injected};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// Pause when the system gives no connection.
const PAUSE: Duration = Duration::from_millis(250);
/// Maximum time for the connection that wakes the thread at its end.
const WAKING: Duration = Duration::from_secs(3);

/// The thread that accepts connections.
#[derive(Debug)]
pub struct TcpServer {
    address: SocketAddr,
    is_stopped: Arc<AtomicBool>,
    thread: Option<JoinHandle<Option<()>>>,
}

impl TcpServer {
    /// Hands every connection to `serve`, which must not wait for it. Stopping sets `is_stopped`, which connections may watch.
    ///
    /// # Errors
    /// The system gives no thread, or the listener has no address.
    pub fn start(
        listener: TcpListener,
        (name, supervisor): (&'static str, &Supervisor),
        is_stopped: Arc<AtomicBool>,
        mut serve: impl FnMut(TcpStream) + Send + 'static,
    ) -> io::Result<Self> {
        let (address, flag) = (listener.local_addr()?, Arc::clone(&is_stopped));
        let thread = supervisor.spawn(name, move || {
            for stream in listener.incoming() {
                if flag.load(Ordering::Acquire) {
                    return;
                }
                injected::point(name);
                match stream {
                    Ok(stream) => serve(stream),
                    // Usually there are no descriptors left for the moment.
                    Err(_) => std::thread::sleep(PAUSE),
                }
            }
        })?;
        Ok(Self { address, is_stopped, thread: Some(thread) })
    }

    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Takes no more connections.
    pub fn stop(&mut self) {
        self.is_stopped.store(true, Ordering::Release);
        // The thread sits in `accept`; a connection wakes it.
        let ip = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
            IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::V6(Ipv6Addr::LOCALHOST),
            ip => ip,
        };
        let _woken = TcpStream::connect_timeout(&SocketAddr::new(ip, self.address.port()), WAKING);
        if let Some(thread) = self.thread.take() {
            // A panic was reported.
            let _panicked = thread.join();
        }
    }
}
