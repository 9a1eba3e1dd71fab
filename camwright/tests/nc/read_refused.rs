// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Refused programs: each refusal with its line and sentence.

use camwright::gcode::{Dialect, MAX_BLOCKS, MAX_TEXT_BYTES, ProgramFile, XValues, read};

fn file(name: &str, text: impl Into<String>) -> ProgramFile {
    ProgramFile { name: name.into(), text: text.into() }
}

#[track_caller]
fn refused(dialect: Dialect, files: &[ProgramFile], sentence: &str) {
    match read(dialect, XValues::Radius, files) {
        Ok(motion) => panic!("{sentence:?} was expected, it was read: {motion:?}"),
        Err(error) => assert_eq!(error.to_string(), sentence),
    }
}

/// Lines within a good beginning and end of LinuxCNC; what is expected names its line from 1.
#[track_caller]
fn linuxcnc(lines: &str, sentence: &str) {
    let text = format!("{lines}\nM2\n").replace("BEGIN", "G21 G90 G93 G0 X0 C0");
    refused(Dialect::LinuxCnc, &[file("a.ngc", text)], &format!("a.ngc, line {sentence}"));
}

#[track_caller]
fn fanuc(lines: &str, sentence: &str) {
    let text = format!("%\nO1\nG21 G90 G93\n{lines}\nM30\n%\n");
    refused(Dialect::Fanuc, &[file("O0001.NC", text)], &format!("O0001.NC, line {sentence}"));
}

#[track_caller]
fn siemens(lines: &str, sub: &str, sentence: &str) {
    let text = format!("G71 G90 G93\n{lines}\nM30\n");
    let mut files = vec![file("A.MPF", text)];
    if !sub.is_empty() {
        files.push(file("SUB_A.SPF", sub));
    }
    refused(Dialect::Siemens, &files, sentence);
}

#[test]
fn words_that_are_not_understood() {
    linuxcnc("BEGIN\nG1 X1 Q2 F1", "2: the word Q2 is not understood here");
    linuxcnc("BEGIN\nG0 A5", "2: the word A5 is not understood here");
    linuxcnc("BEGIN\nG38.2 X1 F1", "2: the word G38.2 is not understood here");
    linuxcnc("BEGIN\nM101", "2: the word M101 is not understood here");
    linuxcnc("BEGIN\nG0 X1 F60", "2: the word F60 is not understood here");
    linuxcnc("#1=5", "1: \"#1=5\" is no word that is read here");
    linuxcnc("o<a> while [1]", "1: \"o<a> while [1]\" is no word that is read here");
    linuxcnc("o100 sub", "1: \"o100 sub\" is no word that is read here");
    linuxcnc("BEGIN\nX1µ", "2: \"µ\" is no word that is read here");
    linuxcnc("BEGIN\nG52 X1 G1 X2", "2: X is there twice in one block");
    linuxcnc("BEGIN\nG52 X1 G1 F2", "2: the word F2 is not understood here");
    linuxcnc("BEGIN\nG4 P1 X2", "2: the word X2 is not understood here");
    fanuc("G92.1", "4: the word G92.1 is not understood here");
    fanuc("G1 X1. F1.; G0", "4: \";\" is no word that is read here");
    siemens("R1=5", "", "A.MPF, line 2: \"=5\" is no word that is read here");
    siemens("STOPRE", "", "A.MPF, line 2: subprogram STOPRE is missing");
    siemens("MSG(1)", "", "A.MPF, line 2: subprogram MSG is missing");
    siemens("OTOL=1", "", "A.MPF, line 2: the word OTOL is not understood here");
    siemens("G0 X1 CTOL=1", "", "A.MPF, line 2: the word CTOL=1 is not understood here");
    siemens("DIAMON(1)", "", "A.MPF, line 2: the word DIAMON is not understood here");
    siemens("G52 X1", "", "A.MPF, line 2: the word G52 is not understood here");
}

#[test]
fn words_that_exclude_each_other() {
    linuxcnc("BEGIN\nG0 G1 X1 F1", "2: G0 and G1 exclude each other in one block");
    linuxcnc("G93 G94", "1: G93 and G94 exclude each other in one block");
    linuxcnc("G90 G90", "1: G90 is there twice in one block");
    linuxcnc("G7 G8", "1: G7 and G8 exclude each other in one block");
    linuxcnc("M3 M5 S1", "1: M3 and M5 exclude each other in one block");
    linuxcnc("G92.1 G4 P1", "1: G92.1 and G4 exclude each other in one block");
    linuxcnc("BEGIN\nX1 X2", "2: X is there twice in one block");
    siemens("TRANS DIAMOF", "", "A.MPF, line 2: TRANS and DIAMOF exclude each other in one block");
    siemens("G642 CTOL=1 CTOL=2", "", "A.MPF, line 2: CTOL is there twice in one block");
    siemens("SUB_A M30", "PROC SUB_A\nM17\n", "A.MPF, line 2: the block: it calls and ends, or calls twice");
}

#[test]
fn what_is_understood_and_must_not_be() {
    linuxcnc("BEGIN\nG2 X1 F1", "2: G2: arcs are not read; C and X make curves of straight blocks");
    linuxcnc("G20", "1: G20: inches are not read; the program must be metric");
    siemens("G70", "", "A.MPF, line 2: G70: inches are not read; the program must be metric");
    siemens("G700", "", "A.MPF, line 2: G700: inches are not read; the program must be metric");
    linuxcnc("G91", "1: G91: incremental targets are not read: an error of one block would be in all that follow");
    linuxcnc("G95", "1: G95: a feed per turn of the cutter says no time; G93 is needed");
    linuxcnc("G41", "1: G41: compensation of the radius is not read; targets are places of the cutter's centre");
    linuxcnc("G55", "1: G55: another zero point than that of G54 is not read");
    linuxcnc("/G0", "1: /: a switch at the machine decides if it is executed");
    linuxcnc(
        "BEGIN\nG94\nG1 X1 F100",
        "3: G1: what a feed in mm/min means for C differs from control to control; G93 is needed",
    );
    linuxcnc("G64 P0.1 Q0.1", "1: Q: blocks within a tolerance would be replaced by one; only Q0 is read");
    linuxcnc("G64 P-1", "1: the path tolerance: it must be positive");
    linuxcnc("(py,import os)", "1: the comment (py,…) is executed by the control with unknown effect");
    linuxcnc("; LOGOPEN,x", "1: the comment (LOGOPEN,…) is executed by the control with unknown effect");
    fanuc("M99", "4: a return: M99 in a main program that was not called; a control would restart it or stop");
    siemens(
        "DIAMON\nTRANS X=1",
        "",
        "A.MPF, line 3: TRANS: whether a shift of X is a diameter depends on the control; DIAMOF is needed before it",
    );
}

#[test]
fn motions_that_lack_something() {
    linuxcnc("BEGIN\nG1 X1", "2: G1 needs an F of its own: with G93 it holds for one block");
    linuxcnc("BEGIN\nG1 X1 F1\nX2", "3: G1 needs an F of its own: with G93 it holds for one block");
    linuxcnc("BEGIN\nG1 X1 F0", "2: F0: a feed must be positive");
    linuxcnc("BEGIN\nG1 X1 F-3", "2: F-3: a feed must be positive");
    linuxcnc("BEGIN\nG1", "2: G1 needs an axis");
    linuxcnc("BEGIN\nG80\nX5", "3: a target needs G0 or G1");
    linuxcnc("G21 G90\nX5", "2: a target needs G0 or G1");
    linuxcnc("G21\nG0 X5", "2: a motion needs metric and absolute coordinates, stated before it");
    linuxcnc("G90\nG0 X5", "2: a motion needs metric and absolute coordinates, stated before it");
    linuxcnc("BEGIN\nG52", "2: G52 needs an axis");
    linuxcnc("G4", "1: G4 needs a positive time in seconds");
    linuxcnc("G4 P0", "1: G4 needs a positive time in seconds");
    linuxcnc("M6", "1: M6 needs a tool: T before it or in the same block");
    linuxcnc("M4", "1: M4 needs a speed: S before it or in the same block");
    linuxcnc("S0", "1: S0: a spindle speed must be positive");
    linuxcnc("T0", "1: T0: a whole number within 1 to 9999 is needed");
    linuxcnc("T1.5", "1: T1.5: a whole number within 1 to 9999 is needed");
    linuxcnc("G43", "1: G43 needs a tool: M6 before it");
    linuxcnc("T1 M6\nG43 H2", "2: H2: the length of another tool");
    fanuc("T1 M6\nG43", "5: G43 needs H with the number of the tool");
    fanuc("G5.1", "4: G5.1 needs Q0 or Q1");
    fanuc("G5.1 Q2", "4: Q2: a whole number within 0 to 1 is needed");
    fanuc("G65", "4: G65 needs P with a program's number");
    fanuc("M98", "4: M98 needs P with a program's number");
    fanuc("G65 P1 B1.", "4: B needs A in the same block");
    siemens("D2", "", "A.MPF, line 2: D2: a whole number within 1 to 1 is needed");
}

#[test]
fn numbers_that_cannot_be_read() {
    let number = |text: &str| format!("2: \"{text}\" is no decimal number below 100000000 with at most 9 places");
    for text in ["100000000", "-1000000000000000000000000000000", "0.1234567890", ".", "-", "+."] {
        linuxcnc(&format!("BEGIN\nG0 X{text}"), &number(text));
    }
    linuxcnc("BEGIN\nG0 X", &number(""));
    linuxcnc("BEGIN\nX1.2.3", "2: \".3\" is no word that is read here");
    linuxcnc("BEGIN\nX[1", "2: \"\" is no word that is read here");
    linuxcnc("BEGIN\nX#1", "2: #1 was not passed by the call");
    linuxcnc("BEGIN\nX#", "2: # was not passed by the call");
    linuxcnc("BEGIN\nX#99999999999999999999999", "2: #99999999999999999999999 was not passed by the call");
    siemens("G0 X=PHASE", "", "A.MPF, line 2: PHASE was not passed by the call");
    fanuc(
        "G0 X10",
        "4: X10 has no decimal point; on this control that counts increments or units, as a parameter says",
    );
    fanuc(
        "G1 X1. F20",
        "4: F20 has no decimal point; on this control that counts increments or units, as a parameter says",
    );
    fanuc(
        "G65 P2 A5",
        "4: A5 has no decimal point; on this control that counts increments or units, as a parameter says",
    );
}

#[test]
fn comments_must_be_closed() {
    linuxcnc("(one\ntwo)", "1: the comment is not closed");
    linuxcnc("(one (two))", "1: the comment is not closed");
    fanuc("(", "4: the comment is not closed");
    linuxcnc("G21 ) G90", "1: \") G90\" is no word that is read here");
}

#[test]
fn calls_of_what_is_not_there_or_runs_already() {
    linuxcnc("o<b> call", "1: subprogram b is missing");
    linuxcnc("o<b> call 5", "1: \"5\" is no word that is read here");
    fanuc("M98 P7", "4: subprogram 7 is missing");
    fanuc("M98 P1", "4: subprogram 1 is missing");
    linuxcnc("o<a> sub\no<a> call\no<a> endsub\no<a> call", "2: subprogram a is called while it is running");
    linuxcnc(
        "o<a> sub\no<b> call\no<a> endsub\no<b> sub\no<a> call\no<b> endsub\no<a> call",
        "5: subprogram a is called while it is running",
    );
    let subs: String =
        (0..9).map(|depth| format!("o<s{depth}> sub\no<s{}> call\no<s{depth}> endsub\n", depth + 1)).collect();
    linuxcnc(
        &format!("{subs}o<s9> sub\no<s9> endsub\no<s0> call"),
        "23: subprogram s8 would be called 8 calls deep, that is too deep",
    );
    linuxcnc("o<a> sub\no<a> endsub", "2: subprogram a is never called, so it was not read");
    let nine = "[1]".repeat(9);
    linuxcnc(&format!("o<a> sub\no<a> endsub\no<a> call {nine}"), "3: \"[1]\" is no word that is read here");
    siemens(
        "SUB_A(1)",
        "PROC SUB_A(REAL A, REAL B)\nM17\n",
        "A.MPF, line 2: SUB_A is called with 1 parameters, 2 are declared",
    );
    siemens(
        "EXTERN SUB_A(REAL)",
        "PROC SUB_A\nM17\n",
        "A.MPF, line 2: SUB_A is called with 1 parameters, 0 are declared",
    );
    siemens("EXTERN SUB_B(REAL)", "", "A.MPF, line 2: subprogram SUB_B is missing");
}

#[test]
fn programs_that_are_not_whole() {
    refused(Dialect::LinuxCnc, &[], ", line 1: there is no program");
    refused(Dialect::Fanuc, &[file("a", "")], "a, line 1: there is no program");
    refused(Dialect::LinuxCnc, &[file("a", "G21\n")], "a, line 2: the program ends here without M2 or M30");
    refused(Dialect::LinuxCnc, &[file("a", "%\nM2\n")], "a, line 3: the program ends here without %");
    refused(Dialect::LinuxCnc, &[file("a", "M2\n%\n")], "a, line 2: \"%\" is no word that is read here");
    refused(
        Dialect::LinuxCnc,
        &[file("a", "%\nM2\n%\nG0\n")],
        "a, line 4: there is text behind the end of the program",
    );
    refused(Dialect::LinuxCnc, &[file("a", "M2\nG0 X1\n")], "a, line 2: there is text behind the end of the program");
    refused(Dialect::LinuxCnc, &[file("a", "o<a> sub\nM2\n")], "a, line 3: the program ends here without endsub");
    refused(Dialect::LinuxCnc, &[file("a", "%\no<a> sub\n%\n")], "a, line 3: the program ends here without endsub");
    refused(
        Dialect::Fanuc,
        &[file("a", "%\nO1\nM98 P2\nM30\nO2\nG90\n%\n")],
        "a, line 7: the program ends here without M99",
    );
    refused(
        Dialect::Fanuc,
        &[file("a", "%\nO1\nM98 P2\nM30\nO2\nM99\nG90\n%\n")],
        "a, line 7: there is text behind the end of the program",
    );
    refused(Dialect::Fanuc, &[file("a", "%\nG90\nO1\nM30\n%\n")], "a, line 2: \"G90\" is no word that is read here");
    refused(Dialect::Fanuc, &[file("a", "O1x\nM30\n")], "a, line 1: \"O1x\" is no word that is read here");
    refused(Dialect::Fanuc, &[file("a", "O1\nM30\nO01\nM99\n")], "a, line 4: program 1 is there twice");
    linuxcnc("o<a> sub\no<b> sub", "2: o<b>: a subprogram begins within another");
    linuxcnc("o<a> endsub", "1: o<a>: a subprogram ends that was not begun");
    linuxcnc("o<a> sub\no<b> endsub", "2: o<b>: it ends a subprogram of another name");
    linuxcnc("o<a> sub\nM2\no<a> endsub\no<a> call", "2: the end: the program would end within a subprogram");
    refused(
        Dialect::LinuxCnc,
        &[file("a", "M2\n"), file("b.ngc", "o<a> sub\no<a> endsub\n")],
        "b.ngc, line 1: o<a>: a subprogram of a file of its own must have the file's name",
    );
}

#[test]
fn subprograms_of_sinumerik_say_what_they_are() {
    let at = |line: u32, text: &str| format!("SUB_A.SPF, line {line}: \"{text}\" is no word that is read here");
    siemens("SUB_A", "; title\nG90\n", &at(2, "G90"));
    siemens("SUB_A", "PROC SUB_A(INT A)\n", &at(1, "PROC SUB_A(INT A)"));
    siemens("SUB_A", "PROC SUB_A(REAL A, REAL A)\n", &at(1, "PROC SUB_A(REAL A, R"));
    siemens("SUB_A", "PROC SUB_A(REAL A) SAVE\n", &at(1, "SAVE"));
    siemens("SUB_A", "PROC SUB_B\nM17\n", "SUB_A.SPF, line 1: PROC SUB_B: the file must have its name and .SPF");
    siemens("SUB_A", "PROC SUB_A\nG90\n", "SUB_A.SPF, line 3: the program ends here without M17 or RET");
}

#[test]
fn too_much_is_refused_in_bounded_time_and_memory() {
    refused(
        Dialect::LinuxCnc,
        &[file("a", " ".repeat(513))],
        "a, line 1: the line has 513 bytes, at most 512 are read",
    );
    let half = "\n".repeat(MAX_TEXT_BYTES / 2 + 1);
    let sentence = format!("a, line 1: the files have {} bytes, at most {MAX_TEXT_BYTES} are read", MAX_TEXT_BYTES + 2);
    refused(Dialect::Fanuc, &[file("a", half.clone()), file("b", half)], &sentence);

    // 60⁴ calls of nothing but comments.
    let mut text = String::new();
    for depth in 0..4 {
        text += &format!("o<s{depth}> sub\n");
        text += &format!("o<s{}> call\n", depth + 1).repeat(60);
        text += &format!("o<s{depth}> endsub\n");
    }
    text += "o<s4> sub\n(nothing)\no<s4> endsub\no<s0> call\nM2\n";
    let error = read(Dialect::LinuxCnc, XValues::Radius, &[file("a", text)]).expect_err("it is refused");
    assert!(error.to_string().ends_with(&format!("more than {MAX_BLOCKS} blocks are executed")), "{error}");
}
