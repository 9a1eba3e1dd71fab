// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages as octets: CDR without knowing the type, and the writer that carries octets.

use std::{convert::Infallible, fmt};

use rustdds::{
    RepresentationIdentifier,
    bytes::Bytes,
    no_key,
    serialization::{deserialize_from_cdr_with_rep_id, to_writer_with_rep_id},
};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{DeserializeOwned, SeqAccess, Visitor},
    ser::SerializeTuple,
};

/// Encapsulation header of little-endian CDR, the only one ROS 2 implementations write on the machines we run on.
pub(super) const CDR_LE_HEADER: [u8; 4] = [0, 1, 0, 0];

/// The body of a message of any type, without its encapsulation header.
///
/// Serialised as a tuple of octets, which CDR writes without length and without padding; read until the end of the sample.
#[derive(Debug, Clone, Default)]
pub(super) struct Octets(pub(super) Vec<u8>);

impl Serialize for Octets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|octet| tuple.serialize_element(octet))?;
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for Octets {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RemainingBytes;
        impl<'de> Visitor<'de> for RemainingBytes {
            type Value = Octets;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("octets")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut octets: A) -> Result<Octets, A::Error> {
                let mut body = Vec::with_capacity(256);
                // The end of the sample shows as a failure to read one more octet.
                while let Ok(Some(octet)) = octets.next_element::<u8>() {
                    body.push(octet);
                }
                Ok(Octets(body))
            }
        }
        deserializer.deserialize_tuple(usize::MAX, RemainingBytes)
    }
}

/// Serialises a message as the body of a sample.
pub(super) fn to_cdr<T: Serialize>(value: &T) -> Result<Bytes, String> {
    let mut body = Vec::with_capacity(128);
    to_writer_with_rep_id(&mut body, value, RepresentationIdentifier::CDR_LE).map_err(|error| error.to_string())?;
    Ok(Bytes::from(body))
}

/// Reads a message from the body of a sample.
pub(super) fn from_cdr<T: DeserializeOwned>(body: &[u8]) -> Result<T, String> {
    deserialize_from_cdr_with_rep_id::<T>(body, RepresentationIdentifier::CDR_LE)
        .map(|(value, _)| value)
        .map_err(|error| error.to_string())
}

/// Lets a DDS writer send bodies that are serialised already.
#[derive(Debug)]
pub(super) struct RawBytes;

impl no_key::SerializerAdapter<Bytes> for RawBytes {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Bytes) -> Result<Bytes, Infallible> {
        Ok(value.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
    struct ReceivedSample {
        flag: bool,
        number: f64,
        text: String,
        list: Vec<u16>,
    }

    #[test]
    fn octets_are_the_body_of_any_message() {
        let sample = ReceivedSample { flag: true, number: 0.1, text: "Nocken ß".into(), list: vec![1, 2, 3] };
        let body = to_cdr(&sample).expect("serialisable");
        let octets: Octets = from_cdr(&body).expect("octets are never refused");
        assert_eq!(octets.0, body);
        assert_eq!(to_cdr(&octets).expect("serialisable"), body);
        assert_eq!(from_cdr::<ReceivedSample>(&octets.0).expect("the same body"), sample);
        assert_eq!(from_cdr::<Octets>(&[]).expect("empty").0, Vec::<u8>::new());
        assert!(from_cdr::<ReceivedSample>(&body[..9]).is_err(), "a cut message is refused");
    }
}
