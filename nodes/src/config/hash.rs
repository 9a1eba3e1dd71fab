//! One hash over several files.

use sha2::{Digest, Sha256};

/// SHA-256 over files one after the other, each with its length first, so that no two sets of files give the same bytes.
#[derive(Debug, Clone, Default)]
pub(super) struct FileHash(Sha256);

impl FileHash {
    pub(super) fn add(&mut self, file: &[u8]) {
        self.0.update((file.len() as u64).to_le_bytes());
        self.0.update(file);
    }

    /// 64 hexadecimal digits.
    pub(super) fn hex(self) -> String {
        self.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
