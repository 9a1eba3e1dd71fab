//! What the sources promise about each other: who may look at whom, and where which thing is named.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The machine's description. `machine::wheel_description` and its like are parts of it.
const DESCRIPTION: &str = "machine::description";

/// The core's modules in the order in which the data walks; a line looks only at itself and at lines above it. The machine stands
/// twice: what it is described by, which everybody takes limits from, and what it does.
const ORDER: &[&[&str]] = &[
    &["units"],
    &["keyframe", "kept", "kept_cases"],
    &["numeric"],
    &["contact_law"],
    &["raw_part"],
    &["wheel"],
    &["follower"],
    &["motion_law"],
    &["lift"],
    &["contour"],
    &["surface"],
    &["rake_section"],
    &["form"],
    &["inspection"],
    &["capability"],
    &["compensation"],
    &["tool_path"],
    &["cutter_path"],
    &["groove"],
    &["milling_job"],
    &["archimedean"],
    &["nc"],
    &["post"],
    &[DESCRIPTION, "machine::fixture"],
    &["insert_path"],
    &["insert_clearance"],
    &["setpoint"],
    &["runout"],
    &["machine::state"],
    &["dressing"],
    &["job"],
    &["turning_job"],
    &["infeed"],
    &["plan"],
    &["cut_motion"],
    &["spiral_motion"],
    &["giving_way"],
    &["path_stop"],
    &["point_to_point"],
    &["speed_plan"],
    &["plan_check"],
    &["plan_difference"],
    &["program_motion"],
    &["interpolator"],
    &["cycle"],
    &["machine"],
    &["packml"],
    &["loading"],
    &["rehearsal"],
    &["turning_drives"],
    &["cell"],
    &["fault_campaign"],
];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every Rust file below a folder of the repository with its text, by its path from that folder.
fn sources(folder: &str) -> BTreeMap<String, String> {
    fn walk(at: &Path, root: &Path, into: &mut BTreeMap<String, String>) {
        for entry in std::fs::read_dir(at).expect("a folder of the repository").flatten() {
            let path = entry.path();
            if path.is_dir() {
                walk(&path, root, into);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(root).expect("it was found below").display().to_string();
                into.insert(name, std::fs::read_to_string(&path).expect("a source file"));
            }
        }
    }
    let root = repository().join(folder);
    let mut found = BTreeMap::new();
    walk(&root, &root, &mut found);
    assert!(found.len() > 3, "{folder} has sources");
    found
}

/// The text without comments and without what only tests see, which stands at the end of a file.
fn shipped(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    code.lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .fold(String::new(), |all, line| all + line + "\n")
}

/// Files and folders that hold nothing but tests.
fn is_test(file: &str) -> bool {
    file.split('/').any(|part| matches!(part, "tests" | "tests.rs")) || file.ends_with("_tests.rs")
}

/// The module of a file: `machine/wheel_description.rs` is `machine::wheel_description`.
fn module_of(file: &str) -> String {
    file.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::")
}

/// The line of [`ORDER`] with the longest name that a module or a path through modules begins with.
fn line_of(path: &str) -> Option<usize> {
    let is_part = path.split("::").nth(1).is_some_and(|part| part.ends_with("_description"));
    let path = if path.starts_with("machine::") && is_part { DESCRIPTION } else { path };
    let begins = |name: &str| path == name || path.strip_prefix(name).is_some_and(|rest| rest.starts_with("::"));
    let named = ORDER.iter().enumerate().flat_map(|(line, names)| names.iter().map(move |name| (line, *name)));
    named.filter(|(_, name)| begins(name)).max_by_key(|(_, name)| name.len()).map(|(line, _)| line)
}

/// Paths that begin with `crate::`, groups in braces taken apart one level deep.
fn paths(code: &str) -> Vec<String> {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
    let mut found = Vec::new();
    for (_, rest) in code.match_indices("crate::").map(|(at, found)| (at, &code[at + found.len()..])) {
        let end = rest.find(|c| !word(c)).unwrap_or(rest.len());
        let path = &rest[..end];
        match rest[end..].strip_prefix('{').filter(|_| path.is_empty() || path.ends_with("::")) {
            Some(group) => {
                let inner = group.split('}').next().unwrap_or_default();
                found.extend(inner.split(',').map(|name| format!("{path}{}", name.trim())));
            }
            None => found.push(path.to_owned()),
        }
    }
    found
}

#[test]
fn a_module_of_the_core_looks_only_at_those_before_it() {
    let mut wrong = Vec::new();
    let mut seen = 0;
    for (file, text) in sources("camwright/src").iter().filter(|(file, _)| *file != "lib.rs" && !is_test(file)) {
        let module = module_of(file);
        let here = line_of(&module)
            .unwrap_or_else(|| panic!("{file} has no place in `ORDER`: add its module where the data comes to it"));
        // A part of a module with a line of its own would hide behind its parent.
        let part = ORDER[here].iter().any(|name| name.contains("::"));
        assert!(!part || !shipped(text).contains("super::"), "{file} says `super::`, which this test does not follow");
        for path in paths(&shipped(text)) {
            seen += 1;
            match line_of(&path) {
                Some(there) if there <= here => {}
                Some(_) => wrong.push(format!("{file} looks ahead at {path}")),
                None => wrong.push(format!("{file} looks at {path}, which has no place in the order")),
            }
        }
    }
    assert!(seen > 200, "only {seen} paths were looked at");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn only_the_ros_layer_names_the_dds_client() {
    let named = |text: &str| ["ros2_client", "rustdds"].iter().any(|name| shipped(text).contains(name));
    let sources = sources("nodes/src");
    let (layer, others): (Vec<_>, Vec<_>) = sources.iter().partition(|(file, _)| file.starts_with("ros/"));
    assert!(layer.iter().any(|(_, text)| named(text)), "the layer stands on it");
    let wrong: Vec<_> = others.iter().filter(|(_, text)| named(text)).map(|(file, _)| file).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    let core = self::sources("camwright/src");
    let wrong: Vec<_> = core.iter().filter(|(_, text)| named(text)).map(|(file, _)| file).collect();
    assert!(wrong.is_empty(), "the core knows no ROS: {wrong:?}");
}

/// Lengths of messages are in m and those of the core in mm; who goes from one to the other calls `convert`, and nobody multiplies.
/// Files are read in `config`, which knows mm and µm and no m; a PNG says how many of its pixels make a metre.
#[test]
fn only_convert_turns_mm_into_m() {
    let allowed = |file: &str| {
        is_test(file) || file.starts_with("convert/") || file.starts_with("config/") || file == "drawing/png_file.rs"
    };
    let thousands = ["1e3", "1000.0", "1_000.0", "1e-3", "0.001"];
    let factor = |line: &str| {
        thousands.iter().any(|number| {
            line.contains(&format!("{number} *"))
                || ["*", "/"].iter().any(|op| line.contains(&format!("{op} {number}")))
        })
    };
    let mut wrong = Vec::new();
    for (file, text) in sources("nodes/src").iter().filter(|(file, _)| !allowed(file)) {
        for (number, line) in shipped(text).lines().enumerate().filter(|(_, line)| factor(line)) {
            wrong.push(format!("nodes/src/{file}:{}: {}", number + 1, line.trim()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Three packages, arrows one way: the nodes know the core and the messages, which know nobody.
#[test]
fn the_core_and_the_messages_depend_on_nothing_of_the_house() {
    for (package, allowed) in
        [("camwright", &["libm", "nalgebra", "thiserror"][..]), ("msgs", &["ros2-client", "serde", "serde_bytes"])]
    {
        let manifest = std::fs::read_to_string(repository().join(package).join("Cargo.toml")).expect("a manifest");
        let section = manifest.split("[dependencies]").nth(1).expect("it has dependencies");
        let section = section.split("\n[").next().unwrap_or_default();
        for line in section.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
            let name = line.split(['.', ' ', '=']).next().unwrap_or_default();
            assert!(allowed.contains(&name), "{package} depends on {name}");
        }
    }
    let root = std::fs::read_to_string(repository().join("camwright/src/lib.rs")).expect("the core");
    assert!(
        root.contains("#![no_std]"),
        "without std the compiler proves that the core knows no file, clock or thread"
    );
}
