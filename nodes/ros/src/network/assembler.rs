// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Assembler for classic BPF, the language of the kernel's socket filters.
//!
//! A program has an accumulator A, an index X and 16 words of memory, jumps forward only, and ends with the number of octets to pass: 0 drops
//! the datagram. A load beyond its end drops it, too.

use std::collections::HashMap;

use socket2::SockFilter;

/// Instruction codes (`linux/bpf_common.h`).
pub(super) mod code {
    pub(crate) const LOAD_WORD: u16 = 0x20;
    pub(crate) const LOAD_LENGTH: u16 = 0x80;
    pub(crate) const LOAD_WORD_AT_X: u16 = 0x40;
    pub(crate) const LOAD_HALF_AT_X: u16 = 0x48;
    pub(crate) const LOAD_BYTE_AT_X: u16 = 0x50;
    pub(crate) const SET_X: u16 = 0x01;
    pub(crate) const LOAD_X_FROM_MEMORY: u16 = 0x61;
    pub(crate) const STORE_A: u16 = 0x02;
    pub(crate) const STORE_X: u16 = 0x03;
    pub(crate) const ADD: u16 = 0x04;
    pub(crate) const ADD_X: u16 = 0x0c;
    pub(crate) const SUBTRACT_X: u16 = 0x1c;
    pub(crate) const MULTIPLY: u16 = 0x24;
    pub(crate) const SHIFT_RIGHT: u16 = 0x74;
    pub(crate) const AND: u16 = 0x54;
    pub(crate) const GO: u16 = 0x05;
    pub(crate) const IF_EQUAL: u16 = 0x15;
    pub(crate) const IF_EQUAL_X: u16 = 0x1d;
    pub(crate) const IF_GREATER: u16 = 0x25;
    pub(crate) const IF_ANY_BIT: u16 = 0x45;
    pub(crate) const RETURN: u16 = 0x06;
    pub(crate) const A_TO_X: u16 = 0x07;
}

/// A position in the program, placed once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Label(usize);

#[derive(Debug, Clone, Copy)]
enum Instruction {
    Plain { code: u16, k: u32 },
    Go(Label),
    If { code: u16, k: u32, then: JumpTarget, otherwise: JumpTarget },
}

#[derive(Debug, Clone, Copy)]
enum JumpTarget {
    Next,
    Label(Label),
}

/// A program under construction.
#[derive(Debug, Default)]
pub(super) struct Assembler {
    instructions: Vec<Instruction>,
    labels: usize,
    places: HashMap<Label, usize>,
}

impl Assembler {
    pub(super) fn label(&mut self) -> Label {
        self.labels += 1;
        Label(self.labels)
    }

    /// The next instruction is the target of this label.
    pub(super) fn place(&mut self, label: Label) {
        self.places.insert(label, self.instructions.len());
    }

    pub(super) fn op(&mut self, code: u16, k: u32) {
        self.instructions.push(Instruction::Plain { code, k });
    }

    pub(super) fn go(&mut self, label: Label) {
        self.instructions.push(Instruction::Go(label));
    }

    /// Jumps if the condition holds, or goes on.
    pub(super) fn jump_if(&mut self, code: u16, k: u32, then: Label) {
        self.instructions.push(Instruction::If { code, k, then: JumpTarget::Label(then), otherwise: JumpTarget::Next });
    }

    /// Jumps unless the condition holds.
    pub(super) fn jump_unless(&mut self, code: u16, k: u32, otherwise: Label) {
        self.instructions.push(Instruction::If {
            code,
            k,
            then: JumpTarget::Next,
            otherwise: JumpTarget::Label(otherwise),
        });
    }

    /// The program with its jumps resolved; `None` if a label is missing, lies behind, or a conditional jump is too long (255).
    pub(super) fn finish(self) -> Option<Vec<FilterStep>> {
        let distance = |at: usize, label: Label| self.places.get(&label)?.checked_sub(at + 1);
        let short = |at: usize, target: JumpTarget| match target {
            JumpTarget::Next => Some(0),
            JumpTarget::Label(label) => u8::try_from(distance(at, label)?).ok(),
        };
        let resolve = |(at, instruction): (usize, &Instruction)| match *instruction {
            Instruction::Plain { code, k } => Some(FilterStep { code, jt: 0, jf: 0, k }),
            Instruction::Go(label) => {
                Some(FilterStep { code: code::GO, jt: 0, jf: 0, k: u32::try_from(distance(at, label)?).ok()? })
            }
            Instruction::If { code, k, then, otherwise } => {
                Some(FilterStep { code, jt: short(at, then)?, jf: short(at, otherwise)?, k })
            }
        };
        self.instructions.iter().enumerate().map(resolve).collect()
    }
}

/// One instruction as the kernel reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FilterStep {
    pub(super) code: u16,
    pub(super) jt: u8,
    pub(super) jf: u8,
    pub(super) k: u32,
}

impl From<FilterStep> for SockFilter {
    fn from(step: FilterStep) -> Self {
        SockFilter::new(step.code, step.jt, step.jf, step.k)
    }
}
