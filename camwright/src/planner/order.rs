// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The order of the lobes in which the table is on its way for the shortest time.

use super::sequence::RUN_IN_MM;
use crate::job::grinding::JobSpec;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::motion::plan::AxisTarget;
use crate::motion::point_to_point::MoveLaw;
use alloc::vec;
use alloc::vec::Vec;

/// Most lobes for which every order is compared, by dynamic programming; beyond it the two sweeps along the part are.
const MAX_COMPARED: usize = 12;

/// An order of a job's lobes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LobeOrder {
    /// Indices of the lobes, in the order of machining.
    pub lobes: Vec<usize>,
    /// Time that the moves of the table take less than in the order the job gives (ticks).
    pub saved_ticks: u64,
}

/// The order in which the moves of the table, from its home position past every station and home again, take least time. Cuts take
/// the same in every order: C stands at the same phase after each lobe. Ways of X from one lobe to the next, ways to a dresser, and
/// the turns of C of rotary indexing are not counted. Of two equal orders the one nearer to the job's own is taken.
#[must_use]
pub fn fastest_order(job: &JobSpec, machine: &MachineDescription) -> LobeOrder {
    let given: Vec<usize> = (0..job.lobes.len()).collect();
    let stations: Option<Vec<f64>> =
        job.lobes.iter().map(|lobe| Some(machine.station(&lobe.station)?.position_mm)).collect();
    // What the machine lacks is refused elsewhere.
    let Some(stations) = stations else { return LobeOrder { lobes: given, saved_ticks: 0 } };
    let table = TableMoves { machine, home_mm: job.home.z_mm, stations: &stations };
    let lobes = if stations.len() <= MAX_COMPARED { table.best() } else { table.better_sweep() };
    let (before, after) = (table.ticks(&given), table.ticks(&lobes));
    if after < before {
        LobeOrder { lobes, saved_ticks: before - after }
    } else {
        LobeOrder { lobes: given, saved_ticks: 0 }
    }
}

struct TableMoves<'a> {
    machine: &'a MachineDescription,
    home_mm: f64,
    stations: &'a [f64],
}

impl TableMoves<'_> {
    /// A move of the table (ticks).
    fn way(&self, from_mm: f64, to_mm: f64) -> u64 {
        let (axis, index) = (self.machine.axis(Axis::Z), Axis::Z.index());
        let mut from = [0; AXIS_COUNT];
        from[index] = axis.scale.counts(from_mm);
        let target = AxisTarget { axis: Axis::Z, target_counts: axis.scale.counts(to_mm), limits: axis.limits };
        MoveLaw::new(from, &[target], self.machine)
            .map_or(u64::MAX / 1024, |law| law.ticks(self.machine.cycle_time_s()))
    }

    /// From home to a lobe, from lobe to lobe, and home: the table goes to before the switch, and the search from there takes the
    /// same for all.
    fn to_first(&self, lobe: usize) -> u64 {
        self.way(self.home_mm, self.stations[lobe] - RUN_IN_MM)
    }

    fn between(&self, from: usize, to: usize) -> u64 {
        self.way(self.stations[from], self.stations[to] - RUN_IN_MM)
    }

    fn home(&self, from: usize) -> u64 {
        self.way(self.stations[from], self.home_mm)
    }

    fn ticks(&self, order: &[usize]) -> u64 {
        let (Some(first), Some(last)) = (order.first(), order.last()) else { return 0 };
        let between: u64 = order.windows(2).map(|pair| self.between(pair[0], pair[1])).sum();
        self.to_first(*first) + between + self.home(*last)
    }

    /// Held and Karp: for every set of lobes that are done and every last one of them the least time.
    fn best(&self) -> Vec<usize> {
        let n = self.stations.len();
        let sets = 1_usize << n;
        let ways: Vec<Vec<u64>> = (0..n).map(|from| (0..n).map(|to| self.between(from, to)).collect()).collect();
        let mut min = vec![vec![(u64::MAX, usize::MAX); n]; sets];
        for lobe in 0..n {
            min[1 << lobe][lobe] = (self.to_first(lobe), usize::MAX);
        }
        for set in 1..sets {
            for last in (0..n).filter(|last| set & (1 << last) != 0) {
                let here = min[set][last].0;
                if here == u64::MAX {
                    continue;
                }
                for next in (0..n).filter(|next| set & (1 << next) == 0) {
                    let there = &mut min[set | (1 << next)][next];
                    let ticks = here + ways[last][next];
                    if ticks < there.0 {
                        *there = (ticks, last);
                    }
                }
            }
        }
        let mut set = sets - 1;
        let mut lobes = Vec::with_capacity(n);
        let mut last = (0..n).min_by_key(|last| min[set][*last].0.saturating_add(self.home(*last)));
        while let Some(lobe) = last {
            lobes.push(lobe);
            let before = min[set][lobe].1;
            set &= !(1 << lobe);
            last = (before < n).then_some(before);
        }
        lobes.reverse();
        lobes
    }

    /// Along the part one way or the other.
    fn better_sweep(&self) -> Vec<usize> {
        let mut up: Vec<usize> = (0..self.stations.len()).collect();
        up.sort_by(|a, b| self.stations[*a].total_cmp(&self.stations[*b]));
        let down: Vec<usize> = up.iter().rev().copied().collect();
        if self.ticks(&down) < self.ticks(&up) { down } else { up }
    }
}
