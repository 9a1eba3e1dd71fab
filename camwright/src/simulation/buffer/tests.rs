// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::machine::reference::cam_grinder;
use alloc::vec;

const X: usize = 1;
/// X falls steadily, 10 mm/s: 1000 counts a tick.
const SPEED: f64 = -10.0;

fn buffer() -> SetpointBuffer {
    SetpointBuffer::new(&cam_grinder(), Setpoint::default())
}

fn steady(tick: u64) -> Setpoint {
    let mut setpoint = Setpoint::default();
    setpoint.counts[X] = -1000 * i64::try_from(tick).expect("a small tick");
    setpoint.velocity[X] = SPEED;
    setpoint
}

fn rest(counts: i64) -> Setpoint {
    let mut setpoint = Setpoint::default();
    setpoint.counts[X] = counts;
    setpoint
}

/// `count` ticks of steady speed and a stop 20 ticks later, whose quintic keeps half the speed on average.
fn chunk_parts(first: u64, count: u64) -> (Vec<Setpoint>, Vec<TailPoint>) {
    let last = first + count - 1;
    let end = steady(last).counts[X] - 10_000;
    ((first..first + count).map(steady).collect(), vec![TailPoint { tick: last + 20, setpoint: rest(end) }])
}

fn accept(buffer: &mut SetpointBuffer, first: u64, count: u64, executed: u64) -> Result<(), ChunkError> {
    let (dense, tail) = chunk_parts(first, count);
    buffer.accept(&Chunk { first_tick: first, dense: &dense, tail: &tail, is_final: false }, executed)
}

#[test]
fn a_newer_chunk_replaces_from_its_first_tick_on() {
    let mut buffer = buffer();
    assert_eq!(accept(&mut buffer, 1, 10, 0), Ok(()));
    assert_eq!(accept(&mut buffer, 6, 10, 3), Ok(()));
    for tick in 1..=15 {
        assert_eq!((buffer.supply(tick), buffer.at(tick)), (Supply::Dense, Some(steady(tick))), "{tick}");
        assert!(!buffer.is_underrun(tick));
        buffer.executed(tick);
    }
    assert_eq!(buffer.supply(16), Supply::Tail);
    assert!(buffer.is_underrun(16));
}

#[test]
fn a_chunk_that_comes_at_the_last_moment_continues_the_dense_part() {
    let mut buffer = buffer();
    accept(&mut buffer, 1, 5, 0).expect("from rest");
    (1..=5).for_each(|tick| buffer.executed(tick));
    assert_eq!(accept(&mut buffer, 6, 5, 5), Ok(()));
    assert_eq!(buffer.at(6), Some(steady(6)));
}

/// Without news the tail runs out: plausible setpoints to the last one, at rest, then nothing.
#[test]
fn silence_runs_out_on_the_tail_and_ends_at_rest() {
    let description = cam_grinder();
    let check = Plausibility::new(&description);
    let mut buffer = buffer();
    accept(&mut buffer, 1, 10, 0).expect("it starts from rest within what drives can do");
    let mut before = Setpoint::default();
    for tick in 1..=30 {
        let setpoint = buffer.at(tick).expect("dense, then tail");
        assert_eq!(check.misfit(&before, &setpoint), None, "{tick}");
        buffer.executed(tick);
        before = setpoint;
    }
    assert_eq!(before, rest(-20_000));
    assert_eq!((buffer.supply(31), buffer.at(31)), (Supply::Nothing, None));
}

#[test]
fn a_chunk_on_the_tail_continues_the_tail() {
    let mut buffer = buffer();
    let (steady, tail) = chunk_parts(1, 5);
    let first = Chunk { first_tick: 1, dense: &steady, tail: &tail, is_final: true };
    buffer.accept(&first, 0).expect("from rest");
    let before = buffer.at(25).expect("the end of the tail");
    let on_the_way = [8, 9, 10].map(|tick| buffer.at(tick));
    let dense = [before; 3];
    buffer
        .accept(&Chunk { first_tick: 26, dense: &dense, tail: &[], is_final: true }, 7)
        .map_err(drop)
        .expect_err("26 to 28 lies beyond the credit of tick 7");
    buffer.executed(7);
    buffer.accept(&Chunk { first_tick: 26, dense: &dense, tail: &[], is_final: true }, 8).expect("at rest there");
    assert_eq!([9, 10].map(|tick| buffer.at(tick)), on_the_way[1..], "the tail before it stays");
    assert_eq!(buffer.supply(9), Supply::Dense);
    assert_eq!(buffer.at(28), Some(before));
    assert!(!buffer.is_underrun(29), "a final chunk runs out without an underrun");
}

/// A chunk that got lost is not made up for by the stop of the one before.
#[test]
fn a_chunk_after_a_lost_one_is_refused() {
    let mut buffer = buffer();
    accept(&mut buffer, 1, 5, 0).expect("from rest");
    for executed in [0, 4, 7] {
        buffer.executed(executed);
        assert_eq!(accept(&mut buffer, 8, 5, executed), Err(ChunkError::Lost { first_tick: 8, expected: 6 }));
    }
}

#[test]
fn chunks_that_cannot_be_are_refused_and_change_nothing() {
    let mut buffer = buffer();
    accept(&mut buffer, 1, 10, 0).expect("from rest");
    let before = buffer.clone();
    let (dense, tail) = chunk_parts(6, 5);
    let chunk = Chunk { first_tick: 6, dense: &dense, tail: &tail, is_final: false };
    let mut offer = |chunk: Chunk<'_>, executed: u64| {
        let refused = buffer.accept(&chunk, executed);
        assert_eq!(buffer, before);
        refused
    };
    assert_eq!(offer(Chunk { dense: &[], ..chunk }, 3), Err(ChunkError::Empty));
    assert_eq!(offer(chunk, 6), Err(ChunkError::Late { first_tick: 6, executed: 6 }));
    let far = vec![rest(0); 40];
    assert_eq!(
        offer(Chunk { first_tick: 2, dense: &far, ..chunk }, 1),
        Err(ChunkError::BeyondCredit { last_tick: 41, credit: 21 })
    );
    assert_eq!(offer(Chunk { tail: &[], ..chunk }, 3), Err(ChunkError::NotAtRest));
    let early = [TailPoint { tick: 10, ..tail[0] }];
    assert_eq!(offer(Chunk { tail: &early, ..chunk }, 3), Err(ChunkError::TailOrder { index: 0, tick: 10 }));
    let long = vec![tail[0]; MAX_TAIL_POINTS + 1];
    assert!(matches!(offer(Chunk { tail: &long, ..chunk }, 3), Err(ChunkError::TooLong { .. })));
    let mut wild = tail.clone();
    wild[0].setpoint.velocity[0] = f64::INFINITY;
    assert_eq!(offer(Chunk { tail: &wild, ..chunk }, 3), Err(ChunkError::NotFinite { index: 0 }));
    assert!(matches!(offer(Chunk { first_tick: 7, ..chunk }, 3), Err(ChunkError::Misfit { tick: 7, .. })));
    let mut extreme = dense.clone();
    extreme[2].counts = [i64::MIN, i64::MAX, i64::MIN];
    assert!(matches!(offer(Chunk { dense: &extreme, ..chunk }, 3), Err(ChunkError::Misfit { tick: 8, .. })));
}

#[test]
fn a_closed_buffer_runs_out_and_takes_nothing_until_it_is_opened() {
    let mut buffer = buffer();
    accept(&mut buffer, 1, 5, 0).expect("from rest");
    buffer.close();
    assert_eq!(accept(&mut buffer, 4, 5, 2), Err(ChunkError::Closed));
    assert_eq!(buffer.supply(20), Supply::Tail);
    buffer.open(rest(0));
    assert_eq!(buffer.at(5), None);
    assert_eq!(accept(&mut buffer, 1, 5, 0), Ok(()));
}

/// A reading that shifts at tick 8 by 5000 counts: what was sent before is taken in the new reading from there on.
#[test]
fn chunks_connect_across_a_new_zero() {
    for executed_before in [3, 9] {
        let mut buffer = buffer();
        let at_rest = [rest(0); 5];
        let chunk = Chunk { first_tick: 1, dense: &at_rest, tail: &[], is_final: true };
        buffer.accept(&chunk, 0).expect("it rests");
        assert!(buffer.schedule_home(8, Axis::X, 5000));
        for tick in 1..=executed_before {
            buffer.executed(tick);
        }
        let old = [rest(0); 3];
        let new = [rest(-5000); 3];
        let first_tick = executed_before + 1;
        let chunk = |dense| Chunk { first_tick: first_tick.max(8), dense, tail: &[], is_final: true };
        assert!(matches!(buffer.accept(&chunk(&old), executed_before), Err(ChunkError::Misfit { .. })));
        buffer.accept(&chunk(&new), executed_before).expect("it continues in the new reading");
        assert_eq!(buffer.at(first_tick.max(8)), Some(rest(-5000)));
    }
}
