// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages as samples: CDR with its encapsulation header, as messages travel and as bags keep them.

use byteorder::LittleEndian;
use serde::{Serialize, de::DeserializeOwned};

/// Encapsulation header of little-endian CDR, the encoding that ROS 2 implementations write on little-endian machines.
pub const CDR_LE_HEADER: [u8; 4] = [0, 1, 0, 0];

/// Reads a message from a sample as it travels and as bags keep it: with its encapsulation header.
///
/// # Errors
/// Too few octets, an encoding that no ROS 2 implementation writes here, or a body that is not such a message.
pub fn message_from_sample<T: DeserializeOwned>(sample: &[u8]) -> Result<T, String> {
    match sample.split_first_chunk::<4>() {
        Some((header, body)) if header[..2] == CDR_LE_HEADER[..2] => cdr_encoding::from_bytes::<T, LittleEndian>(body)
            .map(|(message, _)| message)
            .map_err(|error| error.to_string()),
        Some((header, _)) => {
            Err(format!("the sample's encoding is {:02x}{:02x}, not little-endian CDR", header[0], header[1]))
        }
        None => Err(format!("the sample has {} octets, its header alone has 4", sample.len())),
    }
}

/// A message as a sample, with its encapsulation header.
///
/// # Errors
/// A message that CDR cannot carry, as one with a text of more than 4 GB.
pub fn sample_from_message<T: Serialize>(message: &T) -> Result<Vec<u8>, String> {
    let mut sample = CDR_LE_HEADER.to_vec();
    cdr_encoding::to_writer::<T, LittleEndian, _>(&mut sample, message).map_err(|error| error.to_string())?;
    Ok(sample)
}
