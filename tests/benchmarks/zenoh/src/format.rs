// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names and attachments as `rmw_zenoh_cpp` writes them: its `docs/design.md` and, for the octets of an attachment, its sources.

/// Number of a message, time of its publication, identity of its publisher.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attachment {
    pub sequence_number: i64,
    pub source_ns: i64,
    pub gid: [u8; 16],
}

/// Two little-endian integers, the length of the identity as one octet, the identity: the form of `zenoh_ext`'s serializer.
const ATTACHMENT_OCTETS: usize = 8 + 8 + 1 + 16;

impl Attachment {
    pub fn to_octets(self) -> [u8; ATTACHMENT_OCTETS] {
        let mut octets = [0; ATTACHMENT_OCTETS];
        octets[..8].copy_from_slice(&self.sequence_number.to_le_bytes());
        octets[8..16].copy_from_slice(&self.source_ns.to_le_bytes());
        octets[16] = 16;
        octets[17..].copy_from_slice(&self.gid);
        octets
    }

    pub fn from_octets(octets: &[u8]) -> Result<Self, String> {
        let wrong = || format!("attachment has {} octets, {ATTACHMENT_OCTETS} are expected", octets.len());
        let (number, rest) = octets.split_first_chunk::<8>().ok_or_else(wrong)?;
        let (source, rest) = rest.split_first_chunk::<8>().ok_or_else(wrong)?;
        let (length, gid) = rest.split_first().ok_or_else(wrong)?;
        if *length != 16 {
            return Err(format!("attachment names an identity of {length} octets, 16 are expected"));
        }
        let gid = gid.try_into().map_err(|_| wrong())?;
        Ok(Self { sequence_number: i64::from_le_bytes(*number), source_ns: i64::from_le_bytes(*source), gid })
    }
}

/// Kind of an entity in its liveliness token.
#[derive(Debug, Clone, Copy)]
pub enum EntityKind {
    Publisher,
    Subscription,
    Service,
}

/// Name and type of a topic or service.
#[derive(Debug, Clone, Copy)]
pub struct RosEndpoint<'a> {
    /// Fully qualified, with its first slash.
    pub name: &'a str,
    /// As DDS names the type; of a service without `Request_`.
    pub type_name: &'a str,
    pub type_hash: &'a str,
}

impl RosEndpoint<'_> {
    pub fn key(&self, domain: u16) -> String {
        format!("{domain}/{}/{}/{}", self.name.trim_matches('/'), self.type_name, self.type_hash)
    }
}

/// A node of one session.
#[derive(Debug, Clone)]
pub struct SessionNode {
    pub domain: u16,
    pub session: String,
    pub name: String,
}

impl SessionNode {
    fn begin(&self, entity: u32, kind: &str) -> String {
        format!("@ros2_lv/{}/{}/0/{entity}/{kind}/%/%/{}", self.domain, self.session, self.name)
    }

    pub fn token(&self) -> String {
        self.begin(0, "NN")
    }

    /// Token of an entity. Only what differs from the defaults (reliable, volatile, keep last 42) stands in its quality of service.
    pub fn entity_token(
        &self,
        entity: u32,
        kind: EntityKind,
        endpoint: &RosEndpoint,
        depth: usize,
        latched: bool,
    ) -> String {
        let kind = match kind {
            EntityKind::Publisher => "MP",
            EntityKind::Subscription => "MS",
            EntityKind::Service => "SS",
        };
        let (begin, name) = (self.begin(entity, kind), endpoint.name.replace('/', "%"));
        let (type_name, type_hash) = (endpoint.type_name, endpoint.type_hash);
        let durability = if latched { "1" } else { "" };
        let depth = if depth == 42 { String::new() } else { depth.to_string() };
        format!("{begin}/{name}/{type_name}/{type_hash}/:{durability}:,{depth}:,:,:,,")
    }
}

/// Identity of an entity: XXH3 (128 bits) of its token, lower half first.
pub fn gid(token: &str) -> [u8; 16] {
    twox_hash::XxHash3_128::oneshot(token.as_bytes()).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HASH: &str = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
    const CHATTER: RosEndpoint =
        RosEndpoint { name: "/chatter", type_name: "std_msgs::msg::dds_::String_", type_hash: HASH };

    fn talker() -> SessionNode {
        SessionNode { domain: 2, session: "8b20917502ee955ac4476e0266340d5c".into(), name: "talker".into() }
    }

    #[test]
    fn keys_and_tokens_are_those_of_the_design_document() {
        assert_eq!(CHATTER.key(0), format!("0/chatter/std_msgs::msg::dds_::String_/{HASH}"));
        let node = "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0";
        assert_eq!(talker().token(), format!("{node}/0/NN/%/%/talker"));
        let publisher = format!("{node}/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/{HASH}/::,7:,:,:,,");
        assert_eq!(talker().entity_token(10, EntityKind::Publisher, &CHATTER, 7, false), publisher);
        assert!(talker().entity_token(10, EntityKind::Publisher, &CHATTER, 42, true).ends_with("/:1:,:,:,:,,"));
    }

    /// The hash of an empty text stands in the specification of XXH3.
    #[test]
    fn identity_is_xxh3_with_the_lower_half_first() {
        let expected = 0x99aa_06d3_0147_98d8_6001_c324_468d_497f_u128;
        assert_eq!(gid(""), expected.to_le_bytes());
    }

    #[test]
    fn attachments_of_any_length_are_read_or_rejected() {
        let attachment = Attachment { sequence_number: 1, source_ns: -2, gid: [7; 16] };
        let octets = attachment.to_octets();
        assert_eq!(Attachment::from_octets(&octets), Ok(attachment));
        let mut wrong_length = octets;
        wrong_length[16] = 15;
        assert!(Attachment::from_octets(&wrong_length).is_err_and(|error| error.contains("15 octets")));
        let longer = [&octets[..], &[0]].concat();
        assert!((0..ATTACHMENT_OCTETS).all(|length| Attachment::from_octets(&octets[..length]).is_err()));
        assert!(Attachment::from_octets(&longer).is_err());
    }
}
