// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Settings of ROS 2 and its DDS vendors that mean nothing here.
//!
//! Security is refused: who enables it relies on it. The others are named in one warning.

/// Options of the environment and the command line that are not supported.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Unsupported {
    /// The value of `ROS_SECURITY_ENABLE`, if it enables security.
    security: Option<String>,
    ignored: Vec<String>,
}

const SECURITY: &str = "ROS_SECURITY_ENABLE";

/// Middleware whose nodes understand RTPS, and so ours.
const RTPS_MIDDLEWARE: [&str; 5] =
    ["rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp", "rmw_cyclonedds_cpp", "rmw_connextdds", "rmw_gurumdds_cpp"];

/// Variables without effect here, with the reason.
const IGNORED: [(&str, &str); 13] = [
    ("ROS_SECURITY_KEYSTORE", "DDS security is not supported"),
    ("ROS_SECURITY_STRATEGY", "DDS security is not supported"),
    ("ROS_SECURITY_ENCLAVE_OVERRIDE", "DDS security is not supported"),
    ("ROS_STATIC_PEERS", "peers are found on this host and, with SUBNET, by multicast"),
    ("ROS_DISCOVERY_SERVER", "no discovery server is asked"),
    ("ROS_SUPER_CLIENT", "no discovery server is asked"),
    ("FASTDDS_DEFAULT_PROFILES_FILE", "it configures Fast DDS"),
    ("FASTRTPS_DEFAULT_PROFILES_FILE", "it configures Fast DDS"),
    ("FASTDDS_BUILTIN_TRANSPORTS", "it configures Fast DDS"),
    ("RMW_FASTRTPS_USE_QOS_FROM_XML", "it configures Fast DDS"),
    ("CYCLONEDDS_URI", "it configures Cyclone DDS"),
    ("NDDS_QOS_PROFILES", "it configures Connext DDS"),
    ("ZENOH_CONFIG_OVERRIDE", "it configures Zenoh"),
];

impl Unsupported {
    pub(super) fn read(variable: impl Fn(&str) -> Option<String>, enclave: Option<&str>) -> Self {
        let off = ["", "0", "false", "off", "no"];
        let security = variable(SECURITY).filter(|value| !off.contains(&value.to_lowercase().as_str()));
        let set = |name: &str| variable(name).filter(|value| !value.is_empty());
        let mut ignored: Vec<String> = IGNORED
            .iter()
            .filter_map(|(name, reason)| set(name).map(|value| format!("{name}={value} ({reason})")))
            .collect();
        if let Some(name) = set("RMW_IMPLEMENTATION").filter(|name| !RTPS_MIDDLEWARE.contains(&name.as_str())) {
            ignored.push(format!("RMW_IMPLEMENTATION={name} (this node speaks RTPS; nodes on {name} do not see it)"));
        }
        if let Some(enclave) = enclave.filter(|enclave| *enclave != "/") {
            ignored.push(format!("--enclave {enclave} (DDS security is not supported)"));
        }
        Self { security, ignored }
    }

    /// Refuses to start a node that relies on what is not there.
    ///
    /// # Errors
    /// Security is enabled.
    pub(super) fn refuse(&self) -> Result<(), String> {
        let Some(value) = &self.security else { return Ok(()) };
        Err(format!(
            "{SECURITY}={value}, but DDS security is not supported: the node would run without authentication and encryption. Unset \
             {SECURITY} to run it unprotected on this host alone (the default discovery range). What protects \
             a cell: docs/guides/network_and_security.md"
        ))
    }

    /// Names what is ignored.
    pub(super) fn warning(&self) -> Option<String> {
        let settings = self.ignored.join(", ");
        (!settings.is_empty())
            .then(|| format!("ignored: {settings}. Settings with an effect: docs/guides/network_and_security.md"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(set: &[(&str, &str)], enclave: Option<&str>) -> Unsupported {
        let value = |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned());
        Unsupported::read(value, enclave)
    }

    #[test]
    fn security_is_refused_with_reason_and_remedy() {
        for value in ["true", "TRUE", "1", "Enforce"] {
            let refusal = read(&[(SECURITY, value)], None).refuse().expect_err(value);
            assert!(refusal.contains(&format!("{SECURITY}={value}")) && refusal.contains("Unset"), "{refusal}");
        }
        for value in ["false", "0", ""] {
            assert_eq!(read(&[(SECURITY, value)], None), Unsupported::default(), "{value}");
        }
    }

    #[test]
    fn what_is_ignored_is_named_in_one_warning() {
        assert_eq!(read(&[("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")], Some("/")).warning(), None);
        let set: Vec<(&str, &str)> = IGNORED.iter().map(|(name, _)| (*name, "x")).collect();
        let all = [&set[..], &[("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")]].concat();
        let unsupported = read(&all, Some("/cell"));
        assert_eq!(unsupported.refuse(), Ok(()));
        let warning = unsupported.warning().expect("all of them");
        for (name, _) in all {
            assert!(warning.contains(name), "{name}: {warning}");
        }
        assert!(warning.contains("--enclave /cell"), "{warning}");
    }
}
