// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `index.html` beside the drawings of a plan: every drawing with one sentence, by lobe.

use crate::drawing::Plot;
use crate::markup::escape;
use std::fmt::Write as _;

/// Content of the page.
pub(crate) struct PictureIndex {
    /// Name of the job, and one line about it.
    pub(crate) job: String,
    pub(crate) title: String,
    /// Verdict of the plan.
    pub(crate) verdict: String,
    /// Warnings about the job, its files and its plan.
    pub(crate) warnings: Vec<String>,
    pub(crate) sections: Vec<PictureSection>,
}

/// The drawings of a lobe, or those of a part.
pub(crate) struct PictureSection {
    pub(crate) heading: String,
    pub(crate) pictures: Vec<Picture>,
}

/// A drawing in the folder of the page.
pub(crate) struct Picture {
    /// Path from the page, without its extension.
    pub(crate) path: String,
    pub(crate) caption: String,
}

impl Picture {
    /// The drawing in a folder beside the page, or next to it.
    pub(crate) fn from_plot(folder: Option<&str>, plot: &Plot) -> Self {
        let path = folder.map_or_else(|| plot.name.clone(), |folder| format!("{folder}/{}", plot.name));
        Self { path, caption: plot.caption.clone() }
    }
}

const STYLE: &str = "\
:root { color-scheme: light; } * { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 12px 16px 40px; color: #16202a; background: #fff; \
font: 16px/1.4 system-ui, \"DejaVu Sans\", sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 26px; margin: 8px 0 2px; } h2 { font-size: 20px; margin: 28px 0 6px; border-bottom: 1px solid #cfd6dd; }
p { margin: 4px 0; } nav a { display: inline-block; padding: 6px 14px 6px 0; } .verdict { font-weight: 600; }
figure { margin: 14px 0 22px; break-inside: avoid; } figcaption { margin-bottom: 4px; }
img { display: block; width: 100%; height: auto; border: 1px solid #cfd6dd; }
@page { size: A4; margin: 10mm; }
@media print { body { max-width: none; padding: 0; font-size: 12px; } nav, .screen { display: none; } h2 { break-after: avoid; } figure { margin: 4px 0 8px; } }
";

impl PictureIndex {
    pub(crate) fn to_html(&self) -> String {
        let mut out = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>Plan of {job}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>Plan of {job}</h1>\n",
            job = escape(&self.job)
        );
        if !self.title.is_empty() {
            let _infallible = writeln!(out, "<p>{}</p>", escape(&self.title));
        }
        let _infallible = writeln!(out, "<p class=\"verdict\">{}</p>", escape(&self.verdict));
        for warning in &self.warnings {
            let _infallible = writeln!(out, "<p>{}</p>", escape(warning));
        }
        if self.sections.len() > 1 {
            out.push_str("<nav>");
            for (number, section) in self.sections.iter().enumerate() {
                let _infallible = write!(out, "<a href=\"#s{number}\">{}</a>", escape(&section.heading));
            }
            out.push_str("</nav>\n");
        }
        out.push_str("<p class=\"screen\">Select a picture to open it at its full size.</p>\n");
        for (number, section) in self.sections.iter().enumerate() {
            let _infallible = writeln!(out, "<section id=\"s{number}\">\n<h2>{}</h2>", escape(&section.heading));
            for picture in &section.pictures {
                let (path, caption) = (in_link(&picture.path), escape(&picture.caption));
                let _infallible = writeln!(
                    out,
                    "<figure><figcaption>{caption} <a class=\"screen\" href=\"{path}.png\">PNG</a></figcaption>\n\
                     <a href=\"{path}.svg\"><img src=\"{path}.svg\" width=\"1122\" height=\"794\" loading=\"lazy\" alt=\"{caption}\"></a></figure>"
                );
            }
            out.push_str("</section>\n");
        }
        out + "</body>\n</html>\n"
    }
}

/// A relative path as a link.
fn in_link(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"-_./".contains(&byte) {
            out.push(char::from(byte));
        } else {
            let _infallible = write!(out, "%{byte:02X}");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_job_stay_text_and_links_stay_links() {
        let index = PictureIndex {
            job: "<b>".into(),
            title: "a & b".into(),
            verdict: "planned".into(),
            warnings: vec!["warning: \"x\"".into()],
            sections: vec![PictureSection {
                heading: "Lobe A 1".into(),
                pictures: vec![Picture { path: "A 1#/contour".into(), caption: "One <sentence>.".into() }],
            }],
        };
        let html = index.to_html();
        for text in [
            "Plan of &lt;b&gt;",
            "a &amp; b",
            "warning: &quot;x&quot;",
            "src=\"A%201%23/contour.svg\"",
            "One &lt;sentence&gt;.",
        ] {
            assert!(html.contains(text), "{text}: {html}");
        }
        assert!(!html.contains("http") && !html.contains("<script"), "{html}");
    }
}
