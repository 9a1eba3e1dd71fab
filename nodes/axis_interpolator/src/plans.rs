// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plans on their way in: pages in any order, a few plans at a time.

use camwright::machine::description::MachineDescription;
use camwright::motion::plan::Plan;
use camwright_files::convert::plan::{PlanPagesError, plan_from_pages};
use camwright_msgs::camwright_msgs::msg::PlanPage;
use std::sync::Arc;

/// Plans kept: the one in execution, and those that may be asked for next.
const KEPT: usize = 4;

/// Pages by plan, and the plan that a goal waits for.
#[derive(Debug, Default)]
pub(super) struct Plans {
    pages: Vec<(String, Vec<PlanPage>)>,
    waiting: Option<String>,
}

impl Plans {
    /// Takes a page; one that is here already is not taken twice.
    pub(super) fn add(&mut self, page: PlanPage) {
        let index = match self.pages.iter().position(|(hash, _)| *hash == page.plan_hash) {
            Some(index) => index,
            None => {
                if self.pages.len() == KEPT {
                    self.pages.remove(0);
                }
                self.pages.push((page.plan_hash.clone(), Vec::new()));
                self.pages.len() - 1
            }
        };
        let pages = &mut self.pages[index].1;
        if !pages.iter().any(|known| known.page == page.page) {
            pages.push(page);
        }
    }

    /// A goal waits for this plan.
    pub(super) fn wait_for(&mut self, hash: String) {
        self.waiting = Some(hash);
    }

    /// The plan that a goal waits for.
    pub(super) fn waiting(&self) -> Option<String> {
        self.waiting.clone()
    }

    /// No goal waits any more.
    pub(super) fn forget_waiting(&mut self) {
        self.waiting = None;
    }

    /// The plan that was waited for; `None` while pages are missing.
    pub(super) fn load(&mut self, hash: &str, machine: &MachineDescription) -> Result<Option<Arc<Plan>>, String> {
        let Some((_, pages)) = self.pages.iter().find(|(known, _)| known == hash) else { return Ok(None) };
        let outcome = match plan_from_pages(pages, machine) {
            Err(PlanPagesError::Incomplete { .. }) => return Ok(None),
            Err(error) => Err(error.to_string()),
            Ok((_, header)) if header.machine_hash != machine.hash => {
                Err(format!("the plan is for machine {}, this one is {}", header.machine_hash, machine.hash))
            }
            Ok((plan, _)) => Ok(Some(Arc::new(plan))),
        };
        self.waiting = None;
        outcome
    }
}
