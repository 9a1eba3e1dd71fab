//! The command line: the whole cell in one process, and the tools around it.
fn main() {}
