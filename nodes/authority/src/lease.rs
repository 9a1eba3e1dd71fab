// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lease of command: one holder at a time, with its timeout, and the participants that have a role in the cell.
//!
//! A state machine without clock or network. Its caller passes the time, by the wall clock and outside of ticks.

use camwright_threads::silence::Silence;
use std::time::{Duration, Instant};

/// GUID of a participant: twelve octets of prefix, and zeros.
pub(super) type Participant = [u8; 16];

/// Lease of a request that says none.
const USUAL_S: f64 = 10.0;
const MAX_LEASE_S: f64 = 86_400.0;
/// Longest name of a holder.
const MAX_NAME: usize = 64;
/// Time after the end of a lease in which work of the members still counts as begun under it.
const GRACE: Duration = Duration::from_secs(2);
/// Time for which a claim to a role that is not free is remembered.
const CLAIM: Duration = Duration::from_secs(1);

/// Participant of an endpoint.
pub(super) fn participant_of(endpoint: [u8; 16]) -> Participant {
    let mut participant = endpoint;
    participant[12..].fill(0);
    participant
}

/// Role of a node of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Interpolator,
    Planner,
}

impl Role {
    /// Name of the role.
    pub fn name(self) -> &'static str {
        match self {
            Role::Interpolator => "axis_interpolator",
            Role::Planner => "job_planner",
        }
    }

    /// Returns the role with this name.
    pub fn named(name: &str) -> Option<Self> {
        [Role::Interpolator, Role::Planner].into_iter().find(|role| role.name() == name)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Holder {
    pub name: String,
    pub participant: Participant,
    pub shared: bool,
    pub lease: Duration,
    until: Instant,
    /// The graph has shown its participant, so that its absence means that it has left.
    is_seen: bool,
}

/// Owner of a role.
#[derive(Debug)]
struct Member {
    participant: Participant,
    silence: Silence,
    busy: bool,
    known: u64,
    /// The graph has shown its participant, so that its absence means that it has left.
    is_seen: bool,
    /// Another participant has claimed the role since the last report.
    is_claimed: bool,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct LeaseRequest<'a> {
    pub name: &'a str,
    pub lease_s: f64,
    pub shared: bool,
}

/// The one lease of a machine.
#[derive(Debug)]
pub(super) struct Lease {
    first_number: u64,
    /// Number of the present state; it differs after every change.
    number: u64,
    holder: Option<Holder>,
    members: [Option<Member>; 2],
    /// Times at which a participant claimed a role that another had.
    claims: [Option<Instant>; 2],
    silence_limit: Duration,
    /// Two living participants claim one role.
    has_conflict: bool,
    /// The machine executes setpoints.
    in_motion: bool,
    /// Work of members counts as begun under a lease until then.
    work_until: Option<Instant>,
}

impl Lease {
    /// Lease without a holder; members are lost after `silence_limit`. The first number differs from those of an earlier run.
    pub(super) fn new(silence_limit: Duration, first_number: u64) -> Self {
        let first_number = first_number.max(1);
        let (number, holder, members, claims) = (first_number, None, [None, None], [None, None]);
        let (has_conflict, in_motion, work_until) = (false, false, None);
        Self { first_number, number, holder, members, claims, silence_limit, has_conflict, in_motion, work_until }
    }

    /// Number of the present state.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    pub(super) fn holder(&self) -> Option<&Holder> {
        self.holder.as_ref()
    }

    /// Time that is left of the lease (s).
    pub(super) fn remaining_s(&self, now: Instant) -> f64 {
        self.holder.as_ref().map_or(0.0, |holder| holder.until.saturating_duration_since(now).as_secs_f64())
    }

    /// Participant that has a role and has received this lease.
    pub(super) fn member(&self, role: Role) -> Option<Participant> {
        let member = self.members[role as usize].as_ref();
        member.filter(|member| self.has_acknowledged(member.known, self.first_number)).map(|member| member.participant)
    }

    /// Returns true once every member has received a state or a later one, and no other waits for the role of a silent member.
    pub(super) fn is_known(&self, number: u64, now: Instant) -> bool {
        let is_claimed = self.claims.iter().flatten().any(|claimed| now.saturating_duration_since(*claimed) < CLAIM);
        !is_claimed && self.members.iter().flatten().all(|member| self.has_acknowledged(member.known, number))
    }

    /// Returns true where a known state is `number` or a later one of this lease.
    fn has_acknowledged(&self, known: u64, number: u64) -> bool {
        (number..=self.number).contains(&known)
    }

    /// Takes or renews command.
    ///
    /// # Errors
    /// The reason why another holder keeps it, or what is wrong with the request.
    pub(super) fn acquire(&mut self, by: Participant, wanted: LeaseRequest<'_>, now: Instant) -> Result<(), String> {
        let lease = duration(wanted.lease_s)?;
        check_name(wanted.name)?;
        self.expire(now);
        if let Some(holder) = &self.holder
            && !holder.may_change(by, wanted.name)
        {
            // A shared lease lets everybody command; its term stays that of its holder.
            return if holder.shared { Ok(()) } else { Err(self.refusal_text(now)) };
        }
        let until = now + lease;
        let is_seen = self.holder.as_ref().is_some_and(|old| old.participant == by && old.is_seen);
        let (name, shared) = (wanted.name.to_owned(), wanted.shared);
        let holder = Holder { name, participant: by, shared, lease, until, is_seen };
        let is_same = self.holder.as_ref().is_some_and(|old| Holder { until, ..old.clone() } == holder);
        self.holder = Some(holder);
        self.work_until = None;
        if !is_same {
            self.number += 1;
        }
        Ok(())
    }

    /// Gives command back. Work that is under way goes on.
    ///
    /// # Errors
    /// The caller does not have it.
    pub(super) fn release(&mut self, by: Participant, name: &str, now: Instant) -> Result<(), String> {
        self.expire(now);
        match &self.holder {
            None => Ok(()),
            Some(holder) if holder.may_change(by, name) => {
                self.end(now);
                Ok(())
            }
            Some(_) => Err(self.refusal_text(now)),
        }
    }

    fn end(&mut self, now: Instant) {
        self.holder = None;
        self.number += 1;
        self.work_until = Some(now + GRACE);
    }

    /// Takes the report of a member.
    ///
    /// # Errors
    /// Another participant has the role and is alive.
    pub(super) fn join(
        &mut self,
        by: Participant,
        role: Role,
        (known, busy): (u64, bool),
        now: Instant,
    ) -> Result<(), String> {
        let (first, last) = (self.first_number, self.number);
        let place = &mut self.members[role as usize];
        match place {
            Some(member) if member.participant == by => {
                // It has received this lease for the first time: its role counts from now on.
                let is_news = known >= first && known <= last && !(first..=last).contains(&member.known);
                self.number += u64::from(is_news);
                member.silence.reset();
                (member.known, member.busy) = (known, busy);
                self.has_conflict |= std::mem::take(&mut member.is_claimed);
            }
            Some(member) if !member.silence.is_lost() => {
                member.is_claimed = true;
                self.claims[role as usize] = Some(now);
                return Err(format!(
                    "another participant is the {} and was active within the last {} s; stop it first",
                    role.name(),
                    member.silence.limit_s()
                ));
            }
            _ => {
                self.claims[role as usize] = None;
                let silence = Silence::new(self.silence_limit);
                *place = Some(Member { participant: by, silence, busy, known, is_seen: false, is_claimed: false });
                self.number += 1;
            }
        }
        self.expire(now);
        Ok(())
    }

    /// Returns once that two participants claim a role and both live: a node that was started again claims it alone.
    pub(super) fn take_conflict(&mut self) -> bool {
        std::mem::take(&mut self.has_conflict)
    }

    /// Looks whether the graph shows the owner of a role, and frees the role once it does not any more.
    pub(super) fn check_graph(&mut self, role: Role, is_shown: impl Fn(&Participant) -> bool) {
        let place = &mut self.members[role as usize];
        let Some(member) = place else { return };
        let is_shown = is_shown(&member.participant);
        if member.is_seen && !is_shown {
            *place = None;
            self.number += 1;
        } else {
            member.is_seen = is_shown;
        }
    }

    /// Looks whether the graph shows the holder, and ends its lease once it does not any more: work that is under way goes on, as after a
    /// release. A shared lease goes by the name; calls of the command line leave the graph at once.
    pub(super) fn check_holder(&mut self, is_shown: impl Fn(&Participant) -> bool, now: Instant) {
        let Some(holder) = self.holder.as_mut().filter(|holder| !holder.shared) else { return };
        let is_shown = is_shown(&holder.participant);
        if holder.is_seen && !is_shown {
            self.end(now);
        } else {
            holder.is_seen = is_shown;
        }
    }

    /// Notes whether the machine executes setpoints.
    pub(super) fn note_motion(&mut self, in_motion: bool) {
        self.in_motion = in_motion;
    }

    /// Ends what has run out: a lease under which nothing is under way, and the role of a silent member.
    pub(super) fn expire(&mut self, now: Instant) {
        for place in &mut self.members {
            if place.as_mut().is_some_and(|member| member.silence.check(now) || member.silence.is_lost()) {
                *place = None;
                self.number += 1;
            }
        }
        let is_working = self.in_motion || self.members.iter().flatten().any(|member| member.busy);
        match &mut self.holder {
            Some(holder) if is_working => holder.until = holder.until.max(now + GRACE),
            Some(holder) if holder.until <= now => self.end(now),
            Some(_) => {}
            None => match self.work_until {
                Some(until) if until <= now => self.work_until = None,
                Some(_) if is_working => self.work_until = Some(now + GRACE),
                _ => {}
            },
        }
    }

    /// Returns true where a participant has a role.
    fn is_member(&self, participant: Participant) -> bool {
        self.members.iter().flatten().any(|member| member.participant == participant)
    }

    /// Returns true where a participant holds command, alone or with all others.
    fn commands(&self, participant: Participant, now: Instant) -> bool {
        let holder = self.holder.as_ref().filter(|holder| holder.until > now);
        holder.is_some_and(|holder| holder.shared || holder.participant == participant)
    }

    /// Returns why a request is refused.
    pub(super) fn refusal(&self, by: Participant, now: Instant) -> Option<String> {
        (!self.commands(by, now) && !self.is_member(by)).then(|| self.refusal_text(now))
    }

    /// Returns why a setpoint or a command to the machine is refused: members send them only under a lease, or for work begun under one.
    pub(super) fn refusal_of_motion(&self, by: Participant, now: Instant) -> Option<String> {
        let may_work = self.holder.is_some() || self.work_until.is_some_and(|until| until > now);
        let is_free = self.commands(by, now) || (may_work && self.is_member(by));
        (!is_free).then(|| self.refusal_text(now))
    }

    fn refusal_text(&self, now: Instant) -> String {
        match &self.holder {
            Some(holder) => held_text(&holder.name, Some(self.remaining_s(now))),
            None => held_text("", None),
        }
    }
}

impl Holder {
    /// Each call of the `ros2` command line is another participant, so a shared lease goes by the name.
    fn may_change(&self, by: Participant, name: &str) -> bool {
        self.participant == by || (self.shared && self.name == name)
    }
}

/// Says who has command and what to do.
pub(super) fn held_text(holder: &str, remaining_s: Option<f64>) -> String {
    match (holder, remaining_s) {
        ("", _) => {
            "no client has command: call machine/take_command first (camwright_msgs/srv/TakeCommand), then ask again"
                .to_owned()
        }
        (holder, Some(remaining_s)) => {
            format!("{holder} has command for {remaining_s:.0} s more; wait, or let {holder} release it")
        }
        (holder, None) => format!("{holder} has command; wait, or let {holder} release it"),
    }
}

fn duration(lease_s: f64) -> Result<Duration, String> {
    match lease_s {
        0.0 => Ok(Duration::from_secs_f64(USUAL_S)),
        lease_s if lease_s > 0.0 && lease_s <= MAX_LEASE_S => Ok(Duration::from_secs_f64(lease_s)),
        _ => Err(format!("lease_s is {lease_s}; it must be 0 (for {USUAL_S} s) to {MAX_LEASE_S}; ask again")),
    }
}

fn check_name(name: &str) -> Result<(), String> {
    let is_fine = !name.trim().is_empty() && name.len() <= MAX_NAME && !name.chars().any(char::is_control);
    is_fine.then_some(()).ok_or_else(|| {
        let shown: String = name.chars().take(MAX_NAME).collect();
        format!("holder is {shown:?}; it must have 1 to {MAX_NAME} octets without control characters")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANNA: Participant = [1; 16];
    const BERT: Participant = [2; 16];
    const NODE: Participant = [3; 16];
    const S: Duration = Duration::from_secs(1);

    fn wanted(name: &str, lease_s: f64) -> LeaseRequest<'_> {
        LeaseRequest { name, lease_s, shared: false }
    }

    fn lease() -> (Lease, Instant) {
        (Lease::new(5 * S / 2, 7), Instant::now())
    }

    #[test]
    fn one_holder_at_a_time_until_it_releases_or_its_time_is_over() {
        let (mut lease, begin) = lease();
        assert!(lease.refusal(ANNA, begin).unwrap().contains("no client has command"));
        lease.acquire(ANNA, wanted("anna", 0.0), begin).unwrap();
        assert_eq!(lease.refusal(ANNA, begin), None);
        let refused = lease.acquire(BERT, wanted("bert", 5.0), begin + 3 * S).unwrap_err();
        assert!(refused.contains("anna has command for 7 s more"), "{refused}");
        assert!(lease.release(BERT, "anna", begin + 3 * S).is_err(), "the name alone is not enough");
        lease.acquire(ANNA, wanted("anna", 0.0), begin + 9 * S).unwrap();
        assert!(lease.refusal(ANNA, begin + 18 * S).is_none(), "it was renewed");
        assert!(lease.refusal(ANNA, begin + 19 * S).is_some());
        lease.acquire(BERT, wanted("bert", 5.0), begin + 19 * S).unwrap();
        lease.release(BERT, "bert", begin + 20 * S).unwrap();
        assert!(lease.holder().is_none());
    }

    #[test]
    fn a_renewal_is_no_news_and_everything_else_is() {
        let (mut lease, begin) = lease();
        let mut numbers = vec![lease.number()];
        lease.acquire(ANNA, wanted("anna", 0.0), begin).unwrap();
        numbers.push(lease.number());
        lease.acquire(ANNA, wanted("anna", 0.0), begin + S).unwrap();
        assert_eq!(Some(&lease.number()), numbers.last());
        lease.acquire(ANNA, wanted("anna", 60.0), begin + S).unwrap();
        numbers.push(lease.number());
        lease.join(NODE, Role::Planner, (0, false), begin + S).unwrap();
        numbers.push(lease.number());
        lease.release(ANNA, "anna", begin + S).unwrap();
        numbers.push(lease.number());
        assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{numbers:?}");
    }

    #[test]
    fn a_shared_lease_goes_by_the_name_and_lets_everybody_command() {
        let (mut lease, begin) = lease();
        lease.acquire(ANNA, LeaseRequest { shared: true, ..wanted("shell", 60.0) }, begin).unwrap();
        assert_eq!(lease.refusal(BERT, begin), None);
        assert_eq!(lease.acquire(BERT, wanted("bert", 5.0), begin), Ok(()));
        assert_eq!(lease.holder().unwrap().name, "shell", "its term stays");
        lease.release(BERT, "shell", begin).unwrap();
        assert!(lease.refusal(BERT, begin).is_some());
    }

    #[test]
    fn a_holder_that_has_left_blocks_no_other_client_although_its_work_goes_on() {
        let (mut lease, begin) = lease();
        lease.acquire(ANNA, wanted("anna", 10.0), begin).unwrap();
        lease.check_holder(|_| false, begin);
        assert!(lease.holder().is_some(), "discovery has not shown it yet");
        lease.check_holder(|_| true, begin);
        lease.acquire(ANNA, wanted("anna", 10.0), begin + S).unwrap();
        for tenth in 0..100 {
            let now = begin + tenth * S / 10;
            lease.join(NODE, Role::Planner, (0, true), now).unwrap();
            lease.check_holder(|_| tenth < 50, now);
            lease.expire(now);
            assert_eq!(lease.holder().is_some(), tenth < 50, "after {tenth} tenths");
            assert_eq!(lease.refusal_of_motion(NODE, now), None, "its job comes to its end");
        }
        lease.acquire(BERT, wanted("bert", 5.0), begin + 10 * S).unwrap();
        // A shared lease lasts without its holder.
        lease.release(BERT, "bert", begin + 10 * S).unwrap();
        lease.acquire(BERT, LeaseRequest { shared: true, ..wanted("shell", 60.0) }, begin + 11 * S).unwrap();
        lease.check_holder(|_| true, begin + 11 * S);
        lease.check_holder(|_| false, begin + 12 * S);
        assert!(lease.holder().is_some());
    }

    #[test]
    fn work_under_way_keeps_the_lease_and_outlives_its_release() {
        let (mut lease, begin) = lease();
        lease.acquire(ANNA, wanted("anna", 1.0), begin).unwrap();
        for tenth in 0..100 {
            let now = begin + tenth * S / 10;
            lease.join(NODE, Role::Interpolator, (0, true), now).unwrap();
            lease.expire(now);
        }
        assert_eq!(lease.refusal(ANNA, begin + 10 * S), None);
        lease.release(ANNA, "anna", begin + 10 * S).unwrap();
        assert!(lease.refusal(ANNA, begin + 10 * S).is_some());
        assert_eq!(lease.refusal_of_motion(NODE, begin + 10 * S), None, "it comes to its end");
        lease.join(NODE, Role::Interpolator, (0, false), begin + 10 * S).unwrap();
        lease.expire(begin + 13 * S);
        assert!(lease.refusal_of_motion(NODE, begin + 13 * S).is_some(), "nothing begins without a lease");
        assert!(lease.refusal_of_motion(BERT, begin + 10 * S).is_some());
    }

    #[test]
    fn a_role_is_free_once_its_owner_is_silent_or_has_left() {
        let (mut lease, begin) = lease();
        lease.join(NODE, Role::Planner, (0, false), begin).unwrap();
        assert!(lease.join(BERT, Role::Planner, (0, false), begin).is_err());
        assert!(!lease.take_conflict(), "the first may have ended");
        lease.join(NODE, Role::Planner, (0, false), begin).unwrap();
        assert!(lease.take_conflict() && !lease.take_conflict());
        assert_eq!(lease.refusal(NODE, begin), None, "a member is internal");
        assert!(lease.refusal_of_motion(NODE, begin).is_some(), "it moves nothing without a lease");
        for tenth in 1..40 {
            lease.expire(begin + tenth * S / 10);
        }
        lease.join(BERT, Role::Planner, (0, false), begin + 4 * S).unwrap();
        assert_eq!(lease.member(Role::Planner), None, "it has not heard of this lease yet");
        lease.join(BERT, Role::Planner, (lease.number(), false), begin + 4 * S).unwrap();
        assert_eq!(lease.member(Role::Planner), Some(BERT));
        lease.check_graph(Role::Planner, |_| false);
        assert_eq!(lease.member(Role::Planner), Some(BERT), "the graph has not shown it yet");
        lease.check_graph(Role::Planner, |_| true);
        lease.check_graph(Role::Planner, |_| false);
        lease.join(NODE, Role::Planner, (lease.number(), false), begin + 4 * S).unwrap();
        assert!(!lease.is_known(lease.number(), begin + 4 * S), "it has not heard of its own joining yet");
        lease.join(NODE, Role::Planner, (lease.number(), false), begin + 4 * S).unwrap();
        assert!(lease.is_known(lease.number(), begin + 4 * S));
        assert!(lease.join(BERT, Role::Planner, (0, false), begin + 4 * S).is_err());
        assert!(!lease.is_known(lease.number(), begin + 4 * S), "the first may have ended");
    }

    #[test]
    fn names_and_times_out_of_range_are_refused() {
        let (mut lease, now) = lease();
        for lease_s in [-1.0, f64::NAN, f64::INFINITY, 86_401.0] {
            assert!(
                lease.acquire(ANNA, wanted("anna", lease_s), now).unwrap_err().contains("it must be 0 "),
                "{lease_s}"
            );
        }
        for name in ["", " ", "a\nb", &"x".repeat(65)] {
            assert!(
                lease.acquire(ANNA, wanted(name, 1.0), now).unwrap_err().contains("it must have 1 to "),
                "{name:?}"
            );
        }
        assert!(lease.holder().is_none());
    }
}
