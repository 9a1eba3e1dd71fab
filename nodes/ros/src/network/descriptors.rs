// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sockets of this process that a library has opened: found through `/proc/self/fd`.

use std::{
    collections::BTreeSet,
    fs, io,
    io::{IoSlice, IoSliceMut},
    mem::MaybeUninit,
    net::{Ipv4Addr, SocketAddrV4},
    os::fd::{AsRawFd, OwnedFd, RawFd},
};

use nix::sys::socket::{ControlMessage, MsgFlags};
use rustix::net::{AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SocketFlags, SocketType};
use socket2::{SockFilter, SockRef};

use super::assembler::FilterStep;

/// A socket's number in the kernel.
pub(super) type Inode = u64;

/// The sockets this process has open: descriptor and number.
fn open_sockets() -> io::Result<Vec<(RawFd, Inode)>> {
    let mut sockets = Vec::new();
    for entry in fs::read_dir("/proc/self/fd")? {
        let entry = entry?;
        // A descriptor may have been closed meanwhile.
        let Ok(target) = fs::read_link(entry.path()) else { continue };
        let inode = target.to_str().and_then(|text| text.strip_prefix("socket:[")?.strip_suffix(']')?.parse().ok());
        let fd = entry.file_name().to_str().and_then(|name| name.parse().ok());
        sockets.extend(fd.zip(inode));
    }
    Ok(sockets)
}

/// The numbers of all sockets this process has open.
pub(super) fn inodes() -> io::Result<BTreeSet<Inode>> {
    Ok(open_sockets()?.into_iter().map(|(_, inode)| inode).collect())
}

/// A second descriptor of an open one: sent to ourselves, since the number alone may not be used safely.
fn duplicate(fd: RawFd) -> io::Result<OwnedFd> {
    let (from, to) = rustix::net::socketpair(AddressFamily::UNIX, SocketType::DGRAM, SocketFlags::CLOEXEC, None)?;
    let octet = [IoSlice::new(&[0])];
    nix::sys::socket::sendmsg::<()>(
        from.as_raw_fd(),
        &octet,
        &[ControlMessage::ScmRights(&[fd])],
        MsgFlags::empty(),
        None,
    )?;
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut ancillary = RecvAncillaryBuffer::new(&mut space);
    let mut octet = [0];
    let flags = RecvFlags::CMSG_CLOEXEC | RecvFlags::DONTWAIT;
    rustix::net::recvmsg(&to, &mut [IoSliceMut::new(&mut octet)], &mut ancillary, flags)?;
    let mut received = ancillary.drain().filter_map(|message| match message {
        RecvAncillaryMessage::ScmRights(mut fds) => fds.next(),
        _ => None,
    });
    received.next().ok_or_else(|| io::Error::other("the kernel passed no descriptor"))
}

/// A UDP socket of this process, by a descriptor of our own.
#[derive(Debug)]
pub(super) struct UdpSocket {
    pub(super) inode: Inode,
    fd: OwnedFd,
}

impl UdpSocket {
    /// The sockets bound to this address that are not among the known ones.
    pub(super) fn bound_to(address: SocketAddrV4, known: &BTreeSet<Inode>) -> io::Result<Vec<Self>> {
        let mut found = Vec::new();
        for (fd, inode) in open_sockets()?.into_iter().filter(|(_, inode)| !known.contains(inode)) {
            let Ok(fd) = duplicate(fd) else { continue };
            let socket = SockRef::from(&fd);
            let is_udp = socket.r#type().is_ok_and(|kind| kind == socket2::Type::DGRAM);
            let bound_here = is_udp && socket.local_addr().is_ok_and(|bound| bound.as_socket_ipv4() == Some(address));
            if bound_here {
                found.push(Self { inode, fd });
            }
        }
        Ok(found)
    }

    /// Attaches a filter and discards what was received before it.
    ///
    /// # Errors
    /// The kernel refuses the filter.
    pub(super) fn filter(&self, program: &[FilterStep]) -> io::Result<()> {
        let program: Vec<SockFilter> = program.iter().copied().map(SockFilter::from).collect();
        SockRef::from(&self.fd).attach_filter(&program)?;
        let mut octet = [0_u8; 1];
        while rustix::net::recv(&self.fd, &mut octet, RecvFlags::DONTWAIT | RecvFlags::TRUNC).is_ok() {}
        Ok(())
    }

    /// Binds the socket to an ephemeral port of 127.0.0.1. The kernel sends nothing from there to another host.
    ///
    /// # Errors
    /// The kernel refuses.
    pub(super) fn rebind_to_loopback(&self) -> io::Result<()> {
        // A UDP socket that was bound to no particular address and port loses its port this way and can be bound again.
        rustix::net::connect_unspec(&self.fd)?;
        rustix::net::bind(&self.fd, &SocketAddrV4::new(Ipv4Addr::LOCALHOST, 0))?;
        Ok(())
    }

    /// The first octets of the oldest unread datagram.
    pub(super) fn oldest_unread(&self) -> Option<Vec<u8>> {
        let mut octets = vec![0_u8; 256];
        let flags = RecvFlags::DONTWAIT | RecvFlags::PEEK;
        let (length, _) = rustix::net::recv(&self.fd, octets.as_mut_slice(), flags).ok()?;
        octets.truncate(length);
        Some(octets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::UdpSocket as StdSocket;

    #[test]
    fn a_socket_is_found_by_its_address_and_bound_again() {
        let known = inodes().expect("/proc is mounted");
        let socket = StdSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).expect("a free port");
        let port = socket.local_addr().expect("bound").port();
        let found = UdpSocket::bound_to(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port), &known).expect("/proc");
        let [found] = found.as_slice() else { panic!("{found:?}") };
        found.rebind_to_loopback().expect("the kernel allows it");
        let bound = socket.local_addr().expect("bound");
        assert_eq!(bound.ip(), Ipv4Addr::LOCALHOST);
        // TEST-NET-1, routed or not: no packet may leave from here.
        assert!(socket.send_to(b"x", "192.0.2.77:7400").is_err());
    }
}
