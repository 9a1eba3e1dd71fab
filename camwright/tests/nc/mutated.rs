// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Damaged programs: whatever is in a file, reading it ends with a motion or a sentence.

use super::sample::{random_program, two_cams};
use crate::cams::SplitMix64;
use camwright::gcode::{Dialect, ProgramFile, XValues, read};

/// Fragments of programs, so that damage is not always detected at once.
const PIECES: [&str; 44] = [
    "G0",
    "G1",
    "G93",
    "G94",
    "G52",
    "X",
    "C-",
    "F0.0",
    "F",
    "#1",
    "#2",
    "#99",
    "[",
    "]",
    "(",
    ")",
    ";",
    "%",
    "\n",
    "\r\n",
    " ",
    "o<a> sub\n",
    "o<a> endsub\n",
    "o<a> call",
    "O1001\n",
    "M99",
    "M30\n",
    "M2",
    "G65 P1001 ",
    "M98 P1001\n",
    "TRANS ",
    "=",
    "NC_A(",
    "REAL ",
    "PROC ",
    "EXTERN ",
    "DIAMON\n",
    "MCALL",
    "9999999999",
    ".",
    "-",
    "/",
    "µ",
    "\0",
];

fn at(random: &mut SplitMix64, text: &str) -> usize {
    let mut at = usize::try_from(random.next() % (text.len() as u64 + 1)).expect("an index");
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn damage(random: &mut SplitMix64, files: &mut Vec<ProgramFile>) {
    for _ in 0..1 + random.next() % 4 {
        if files.is_empty() {
            return;
        }
        let which = usize::try_from(random.next() % files.len() as u64).expect("an index");
        let text = &mut files[which].text;
        let (from, to) = (at(random, text), at(random, text));
        let (from, to) = (from.min(to), from.max(to));
        match random.next() % 8 {
            0 => text.replace_range(from..to, ""),
            1 => {
                let copy = text[from..to].to_owned();
                let to = at(random, text);
                text.insert_str(to, &copy);
            }
            2 => text.insert_str(from, random.one_of(&PIECES)),
            3 => text.insert(from, char::from(u8::try_from(random.next() % 128).expect("ASCII"))),
            4 if from < text.len() => {
                text.remove(from);
            }
            5 => text.truncate(to),
            6 => {
                files.remove(which);
            }
            _ => {
                let end = text[from..].find('\n').map_or(text.len(), |end| from + end);
                text.replace_range(from..end, random.one_of(&PIECES));
            }
        }
    }
}

#[test]
fn damaged_programs_are_read_or_refused() {
    let (mut read_well, mut refused) = (0, 0);
    for seed in 0..12_000 {
        let random = &mut SplitMix64(seed);
        let dialect = random.one_of(&Dialect::ALL);
        let program = if seed % 3 == 0 { two_cams(XValues::Radius) } else { random_program(seed % 100) };
        let mut files = dialect.write(&program).expect("it can be written");
        damage(random, &mut files);
        // What is thrown by a panic names the seed.
        let outcome = std::panic::catch_unwind(|| read(dialect, XValues::Radius, &files));
        match outcome.unwrap_or_else(|_| panic!("seed {seed}, {dialect:?}: {files:?}")) {
            Ok(_) => read_well += 1,
            Err(error) => {
                refused += 1;
                let text = error.to_string();
                assert!(text.contains(", line ") && text.len() < 400, "seed {seed}: {text}");
                if let Some(file) = files.iter().find(|file| file.name == error.file) {
                    assert!(error.line as usize <= file.text.lines().count() + 1, "seed {seed}: {text}");
                }
            }
        }
    }
    assert!(read_well > 500 && refused > 5_000, "{read_well} were read, {refused} refused");
}

/// Any bytes that are a text.
#[test]
fn noise_is_refused() {
    for seed in 0..3_000 {
        let random = &mut SplitMix64(seed);
        let pieces = random.next() % 60;
        let text: String = (0..pieces).map(|_| random.one_of(&PIECES)).collect();
        for dialect in Dialect::ALL {
            let name = random.one_of(&["a.ngc", "A.MPF", "O1.NC"]).to_owned();
            let files =
                [ProgramFile { name, text: text.clone() }, ProgramFile { name: "NC_A.SPF".into(), text: text.clone() }];
            let outcome = read(dialect, XValues::Radius, &files);
            assert!(outcome.is_err(), "seed {seed}, {dialect:?}: {text:?}");
        }
    }
}
