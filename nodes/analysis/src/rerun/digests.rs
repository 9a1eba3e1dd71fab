// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Two bags of the same job: the same digests, tick by tick of the job.

use camwright_msgs::camwright_msgs::msg::MachineInput;

/// The digests of the jobs of a bag: how many ticks of the job are in it, and the digest.
type Jobs = Vec<Vec<(u64, u64)>>;

/// Comparison of the digests of two bags.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct DigestComparison {
    jobs: [usize; 2],
    digests: usize,
    /// Job from 1 on, ticks of it up to which all is the same, and those within which it differs.
    first_difference: Option<(usize, u64, u64)>,
}

impl DigestComparison {
    pub(super) fn is_same(&self) -> bool {
        self.first_difference.is_none() && self.jobs[0] == self.jobs[1] && self.digests > 0
    }

    pub(super) fn to_text(&self) -> String {
        let [ours, theirs] = self.jobs;
        match self.first_difference {
            Some((job, same, differs)) => format!(
                "the other run differs: job {job}: the same up to tick {same} of the job, different by tick {differs}"
            ),
            None if ours != theirs => format!("the other run differs: {ours} jobs here, {theirs} there"),
            None if self.digests == 0 => "no job to compare: neither run holds a digest of a job".to_owned(),
            None => format!("the other run is the same: {} digests of {ours} jobs", self.digests),
        }
    }
}

/// Compares the digests of two bags.
pub(super) fn compare(one: &[MachineInput], other: &[MachineInput]) -> DigestComparison {
    compare_jobs(&jobs_of(one), &jobs_of(other))
}

fn jobs_of(inputs: &[MachineInput]) -> Jobs {
    let mut jobs: Jobs = Vec::new();
    for input in inputs.iter().filter(|input| input.kind == MachineInput::DIGEST && input.number > 0) {
        // The first tick of a job has one.
        match jobs.last_mut().filter(|_| input.number > 1) {
            Some(job) => job.push((input.number, input.digest)),
            None => jobs.push(vec![(input.number, input.digest)]),
        }
    }
    jobs
}

fn compare_jobs(ours: &Jobs, theirs: &Jobs) -> DigestComparison {
    let mut compared = DigestComparison { jobs: [ours.len(), theirs.len()], digests: 0, first_difference: None };
    for (job, (ours, theirs)) in (1..).zip(ours.iter().zip(theirs)) {
        let mut same = 0;
        for place in 0..ours.len().max(theirs.len()) {
            let (one, other) = (ours.get(place), theirs.get(place));
            if one != other {
                let differs = one.into_iter().chain(other).map(|(ticks, _)| *ticks).min().unwrap_or(same);
                compared.first_difference = Some((job, same, differs));
                return compared;
            }
            same = one.map_or(same, |(ticks, _)| *ticks);
            compared.digests += 1;
        }
    }
    compared
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_differing_digest_is_reported_with_its_job() {
        let run = vec![vec![(1000, 1), (2000, 2), (2100, 3)], vec![(1000, 4)]];
        assert!(compare_jobs(&run, &run).is_same());
        assert_eq!(compare_jobs(&run, &run).to_text(), "the other run is the same: 4 digests of 2 jobs");
        let mut other = run.clone();
        other[0][2].1 = 9;
        let text = compare_jobs(&run, &other).to_text();
        assert!(text.ends_with("job 1: the same up to tick 2000 of the job, different by tick 2100"), "{text}");
        assert!(!compare_jobs(&run, &run[..1].to_vec()).is_same(), "a job is missing");
        assert!(!compare_jobs(&Vec::new(), &Vec::new()).is_same(), "nothing was compared");
    }

    #[test]
    fn a_job_begins_where_its_ticks_begin_anew() {
        let input = |number, digest| MachineInput { kind: MachineInput::DIGEST, number, digest, ..Default::default() };
        let chunk = MachineInput { kind: MachineInput::CHUNK, number: 7, ..Default::default() };
        let inputs =
            [input(0, 5), input(1, 7), input(1000, 1), chunk, input(1200, 2), input(0, 6), input(1, 7), input(2000, 3)];
        assert_eq!(jobs_of(&inputs), vec![vec![(1, 7), (1000, 1), (1200, 2)], vec![(1, 7), (2000, 3)]]);
    }
}
