//! What `camwright plan` says about a part that is turned.

use camwright::machine::description::Axis;
use camwright_planning::{TurningSummary, turning_notes};

pub(super) fn as_text(summary: &TurningSummary) -> String {
    let mut text = format!(
        "{:<5} {:>8} {:>8} {:>12} {:>8} {:>9} {:>13} {:>9} {:>8}  {}\n",
        "pass",
        "depth mm",
        "left mm",
        "feed mm",
        "turns",
        "cut s",
        "rpm",
        "X mm",
        "cusp um",
        "limit of a slide used most"
    );
    for (index, pass) in summary.passes.iter().enumerate() {
        // C uses all of its acceleration whenever it runs up, which says nothing of the path.
        let slides = pass.limits.iter().filter(|limit| limit.axis != Axis::C.joint());
        let tightest = slides.max_by(|a, b| a.ratio.total_cmp(&b.ratio));
        let limit = tightest.map_or_else(String::new, |limit| {
            let percent = 100.0 * limit.ratio;
            format!(
                "{} of {} at C {:.1} deg, z {:.2} mm, {percent:.1} %",
                limit.quantity, limit.axis, limit.c_deg, limit.z_mm
            )
        });
        let [slowest, fastest] = pass.spindle_rpm;
        text += &format!(
            "{:<5} {:>8.3} {:>8.3} {:>12} {:>8.1} {:>9.3} {:>13} {:>9.3} {:>8.3}  {limit}\n",
            index + 1,
            pass.depth_mm,
            pass.leaves_mm,
            format!("{} per {}", pass.feed_mm, pass.feed_along),
            pass.turns,
            pass.cut_s,
            format!("{slowest:.1}-{fastest:.1}"),
            pass.x_stroke_mm,
            pass.cusp_um,
        );
    }
    text += &format!("\n{:<5} what holds the spindle's speed, share of the way\n", "pass");
    for (index, pass) in summary.passes.iter().enumerate() {
        let bounds: Vec<String> =
            pass.bounds.iter().map(|bound| format!("{} {:.0} %", bound.bound, 100.0 * bound.share)).collect();
        text += &format!("{:<5} {}\n", index + 1, bounds.join("; "));
    }
    text.push('\n');
    for (index, pass) in summary.passes.iter().enumerate() {
        if let Some(hollow) = &pass.hollow {
            text += &format!(
                "pass {}    bridges a hollow of radius {:.3} mm (the insert with its stock has {:.3}) at C {:.1} deg, z {:.3} mm, and leaves \
                 {:.2} um in it\n",
                index + 1,
                hollow.radius_mm,
                hollow.bound_mm,
                hollow.c_deg,
                hollow.z_mm,
                hollow.left_um
            );
        }
    }
    for note in turning_notes(summary) {
        text += &note;
        text.push('\n');
    }
    text + &format!("job       {:.3} s\nplan      {}\n", summary.duration_s, summary.plan_hash)
}
