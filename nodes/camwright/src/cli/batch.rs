//! `camwright run --parts N`: parts one after the other, their size and form, and what they say about the machine.

use super::output::say;
use camwright::cam::capability::Capability;
use camwright::math::units::um_from_mm;
use camwright::planner::{LobeDesign, designs};
use camwright_files::job_file;
use camwright_job_planner::parts::Parts;
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::PartLobe;
use camwright_planning::{self as planning, FORM_TOLERANCE_MM, LobeCapability, MeasuredLobe};
use camwright_ros::{Node, Qos, RosError, Subscription};
use std::sync::Arc;
use std::time::Duration;

/// How long the outlines of a finished part may take to arrive.
const MEASURING: Duration = Duration::from_secs(20);

/// The parts of a batch so far.
pub(super) struct Batch {
    wanted: u32,
    designs: Vec<LobeDesign>,
    outlines: Arc<Parts>,
    parts: Vec<Vec<MeasuredLobe>>,
    plan_hashes: Vec<String>,
    _subscription: Subscription,
}

impl Batch {
    /// Listens to the parts of a job.
    pub(super) fn subscribe(node: &Node, wanted: u32, job: &str, overrides: &[String]) -> Result<Self, RosError> {
        let outlines: Arc<Parts> = Arc::default();
        let into = Arc::clone(&outlines);
        let subscription =
            node.subscribe::<PartLobe>("machine/part", &Qos::latched(32), move |lobe, _| into.take(lobe))?;
        let designs = job_file::load(job, overrides).ok().and_then(|job| designs(&job.spec).ok()).unwrap_or_default();
        Ok(Self { wanted, designs, outlines, parts: Vec::new(), plan_hashes: Vec::new(), _subscription: subscription })
    }

    /// Measures a part that was ground; false if that was the last one.
    pub(super) fn measure(&mut self, result: &RunJobResult) -> bool {
        let names: Vec<&str> = result.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
        let outlines = self.outlines.wait_finished(&names, result.first_tick, MEASURING).unwrap_or_default();
        let measured = outlines.iter().filter_map(|outline| {
            let design = self.designs.iter().find(|design| design.name == outline.name)?;
            planning::measure_lobe(design, outline).ok()
        });
        let measured: Vec<MeasuredLobe> = measured.collect();
        self.parts.push(measured);
        self.plan_hashes.push(result.plan_hash.clone());
        self.parts.len() < self.wanted as usize
    }

    /// Every part that was measured keeps within the tolerance.
    pub(super) fn is_good(&self) -> bool {
        self.parts.iter().flatten().all(|lobe| lobe.form_mm.abs() <= FORM_TOLERANCE_MM)
    }

    fn capability(&self) -> Vec<LobeCapability> {
        planning::capability(&self.parts).unwrap_or_default()
    }

    /// Size and form of every part, and what the batch is capable of.
    pub(super) fn print(&self) {
        say!(
            "size (mean deviation of the base circle, of a journal all round) and form (largest deviation) of each part:"
        );
        for (index, part) in self.parts.iter().enumerate() {
            let lobe = |lobe: &MeasuredLobe| {
                format!("{} {:+.3} um, {:+.3} um", lobe.name, um_from_mm(lobe.size_mm), um_from_mm(lobe.form_mm))
            };
            say!("  part {:<4} {}", index + 1, part.iter().map(lobe).collect::<Vec<_>>().join("; "));
        }
        let capability = self.capability();
        if !capability.is_empty() {
            say!(
                "capability of {} parts (tolerance {} um; Cp = (U - L)/(6 s), Cpk = min(U - m, m - L)/(3 s), of form against U alone):",
                self.parts.len(),
                um_from_mm(FORM_TOLERANCE_MM),
            );
        }
        for lobe in capability {
            say!("  {:<5} size {}; form {}", lobe.name, told(&lobe.size), told(&lobe.form));
        }
    }

    /// The same for machines.
    pub(super) fn json(&self) -> serde_json::Value {
        let parts = self.parts.iter().zip(&self.plan_hashes).map(|(part, plan_hash)| {
            let lobe = |lobe: &MeasuredLobe| {
                serde_json::json!({
                    "name": lobe.name, "size_um": um_from_mm(lobe.size_mm), "form_um": um_from_mm(lobe.form_mm),
                })
            };
            serde_json::json!({ "plan_hash": plan_hash, "lobes": part.iter().map(lobe).collect::<Vec<_>>() })
        });
        let index = |of: &Capability| {
            serde_json::json!({
                "mean_um": um_from_mm(of.mean), "deviation_um": um_from_mm(of.deviation), "cp": of.cp, "cpk": of.cpk,
            })
        };
        let capability = self.capability();
        let capability = capability
            .iter()
            .map(|lobe| serde_json::json!({ "name": lobe.name, "size": index(&lobe.size), "form": index(&lobe.form) }));
        serde_json::json!({
            "tolerance_um": um_from_mm(FORM_TOLERANCE_MM),
            "parts": parts.collect::<Vec<_>>(),
            "capability": capability.collect::<Vec<_>>(),
        })
    }
}

fn told(of: &Capability) -> String {
    let (mean_um, deviation_um) = (um_from_mm(of.mean), um_from_mm(of.deviation));
    let index = |name: &str, value: Option<f64>| value.map_or_else(String::new, |value| format!(", {name} {value:.2}"));
    let indices = format!("{}{}", index("Cp", of.cp), index("Cpk", of.cpk));
    let indices = if indices.is_empty() { ", the parts do not differ".into() } else { indices };
    format!("m {mean_um:+.3} um, s {deviation_um:.3} um{indices}")
}
