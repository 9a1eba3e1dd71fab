# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Peer on eclipse-zenoh that reads what rmw_zenoh_cpp would read, and judges it with code of others.

usage: peer.py CONFIG COUNT SECONDS [hostile]

Reports as JSON, after COUNT samples or SECONDS: tokens, samples, faults of the format, the answer of the service. With `hostile` it first
publishes malformed samples on the topic and calls the service with malformed requests.
"""
import json
import os
import re
import struct
import sys
import threading
import time

import xxhash
import zenoh
from rosbags.typesys import Stores, get_typestore

DOMAIN = os.environ["ROS_DOMAIN_ID"]
SERVICE_TIMEOUT_S = 3.0
TYPES = get_typestore(Stores.ROS2_JAZZY)
CHUNK = "trajectory_msgs/msg/JointTrajectory"


class Peer:
    def __init__(self, session, count):
        self.session, self.count = session, count
        self.lock, self.enough = threading.Lock(), threading.Event()
        self.tokens, self.samples = {}, []
        self.declared = [
            session.liveliness().declare_subscriber(f"@ros2_lv/{DOMAIN}/**", self.on_token, history=True),
            session.declare_subscriber(f"{DOMAIN}/**", self.on_sample),
        ]

    def on_token(self, sample):
        with self.lock:
            self.tokens[str(sample.key_expr)] = sample.kind == zenoh.SampleKind.PUT

    def on_sample(self, sample):
        attachment = sample.attachment.to_bytes() if sample.attachment else b""
        with self.lock:
            self.samples.append((str(sample.key_expr), attachment, sample.payload.to_bytes()))
            if len(self.samples) >= self.count:
                self.enough.set()

    def living(self, kind):
        """Fields of the tokens of one kind of entity."""
        with self.lock:
            tokens = [(token, token.split("/")) for token, alive in self.tokens.items() if alive]
        return [(token, fields) for token, fields in tokens if len(fields) > 5 and fields[5] == kind]

    def faults(self):
        """What differs from the format, each once."""
        faults, last = set(), None
        publishers = self.living("MP")
        expected_hash = TYPES.hash_rihs01(CHUNK)
        identities = {xxhash.xxh3_128_digest(token.encode())[::-1]: fields for token, fields in publishers}
        # The digest is big-endian; reversed it is the lower half first, each half little-endian.
        for token, fields in publishers:
            if len(fields) != 13 or fields[1] != DOMAIN or not re.fullmatch("[1-9a-f][0-9a-f]*", fields[2]):
                faults.add(f"token {token}")
            elif fields[6:8] != ["%", "%"] or not re.fullmatch("1?:1?:1?,[0-9]*:,:,:1?,,", fields[12]):
                faults.add(f"names or quality of service in token {token}")
        for key, attachment, payload in self.samples:
            domain, *name, type_name, type_hash = key.split("/")
            if (domain, name, type_name) != (DOMAIN, ["machine", "setpoints"], "trajectory_msgs::msg::dds_::JointTrajectory_"):
                faults.add(f"key {key}")
            if type_hash != expected_hash:
                faults.add(f"type hash {type_hash}, rosbags computes {expected_hash}")
            if len(attachment) != 33 or attachment[16] != 16:
                faults.add(f"attachment of {len(attachment)} octets")
                continue
            number, source_ns, gid = struct.unpack("<qqx16s", attachment)
            if last is not None and number != last + 1:
                faults.add(f"sequence number {number} after {last}")
            last = number
            if gid not in identities or identities[gid][9:12] != ["%machine%setpoints", type_name, type_hash]:
                faults.add("the identity in the attachment is that of no token of this topic")
            if abs(time.time_ns() - source_ns) > 60_000_000_000:
                faults.add(f"source timestamp {source_ns}")
            message = TYPES.deserialize_cdr(payload, CHUNK)
            if message.joint_names != ["c_axis", "x_axis", "z_axis"] or len(message.points) != 21:
                faults.add("content of the chunk")
            if bytes(TYPES.serialize_cdr(message, CHUNK)) != payload:
                faults.add("rosbags writes the chunk in other octets")
        return sorted(faults)

    def ask(self, key, payload, attachment):
        """Answers of the service, or their errors."""
        options = {"target": zenoh.QueryTarget.ALL_COMPLETE, "consolidation": zenoh.ConsolidationMode.NONE,
                   "timeout": SERVICE_TIMEOUT_S, "payload": payload, "attachment": attachment}
        answers = []
        for reply in self.session.get(key, **{name: value for name, value in options.items() if value is not None}):
            if reply.ok is None:
                answers.append("error: " + reply.err.payload.to_string())
            else:
                answers.append((reply.ok.payload.to_bytes(), reply.ok.attachment.to_bytes() if reply.ok.attachment else b""))
        return answers

    def service_key(self):
        """The key of the service; from its token where one is seen, as known to everybody else."""
        known = [[DOMAIN, "machine/estop", *fields[10:12]] for _, fields in self.living("SS") if fields[9] == "%machine%estop"]
        return "/".join(known[0]) if known else f"{DOMAIN}/machine/estop/*/*"

    def call(self):
        gid = os.urandom(16)
        asked = struct.pack("<qqB16s", 7, time.time_ns(), 16, gid)
        start = time.monotonic()
        answers = self.ask(self.service_key(), bytes([0, 1, 0, 0, 1]), asked)
        if len(answers) != 1 or isinstance(answers[0], str):
            return {"answered": False, "seconds": round(time.monotonic() - start, 3), "errors": answers}
        payload, attachment = answers[0]
        number, _, back = struct.unpack("<qqx16s", attachment)
        return {"answered": payload[:5] == bytes([0, 1, 0, 0, 1]), "same_request": (number, back) == (7, gid),
                "ms": round(1e3 * (time.monotonic() - start), 3)}

    def attack(self):
        """Malformed samples and requests; returns the answers of the service."""
        hash_of = TYPES.hash_rihs01(CHUNK)
        topic = f"{DOMAIN}/machine/setpoints/trajectory_msgs::msg::dds_::JointTrajectory_/{hash_of}"
        good = struct.pack("<qqB16s", 1, time.time_ns(), 16, bytes(16))
        endless = bytes([0, 1, 0, 0]) + bytes(8) + b"\xff\xff\xff\xff"
        for payload, attachment in [(b"", None), (b"x", good), (endless, good), (bytes(4), good[:17]), (b"\xff" * 64, good + b"0")]:
            options = {"attachment": attachment} if attachment else {}
            self.session.put(topic, payload, **options)
        key = self.service_key()
        requests = [(None, None), (b"", good), (b"\xff" * 9, good), (bytes([0, 1, 0, 0, 1]), good[:32])]
        return [answer for request in requests for answer in self.ask(key, *request)]


def main():
    config, count, seconds, *more = sys.argv[1:]
    try:
        session = zenoh.open(zenoh.Config.from_file(config))
    except zenoh.ZError as error:
        print("ready", json.dumps({"opened": False, "reason": str(error), "tokens": 0, "samples": 0}), sep="\n", flush=True)
        return
    with session:
        peer = Peer(session, int(count))
        print("ready", flush=True)
        peer.enough.wait(float(seconds))
        report = {"opened": True, "tokens": sum(peer.tokens.values()), "samples": len(peer.samples), "faults": peer.faults(),
                  "octets": len(peer.samples[0][2]) if peer.samples else 0}
        if more == ["hostile"]:
            report["hostile"] = peer.attack()
        print(json.dumps({**report, "service": peer.call()}), flush=True)


main()
