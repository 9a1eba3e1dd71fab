# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A peer on Cyclone DDS that the tests steer, with the line protocol of `peer.py`. It knows no ROS: names and types are written out as
ROS 2 has them on the wire, which is what its `rmw_cyclonedds_cpp` does too.

    cyclone_peer.py NAME

CYCLONEDDS_URI and ROS_DOMAIN_ID say where it looks; the tests keep it on the loopback interface.
"""

import json
import os
import queue
import sys
import threading
import time
from dataclasses import dataclass

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import Listener, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic
from cyclonedds.util import duration

# How long a command that waits may take unless it says so itself.
PATIENCE_S = 60.0


@dataclass
class String(IdlStruct, typename="std_msgs.msg.dds_.String_"):
    data: str = ""


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Duration(IdlStruct, typename="builtin_interfaces.msg.dds_.Duration_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str = ""


@dataclass
class Point(IdlStruct, typename="trajectory_msgs.msg.dds_.JointTrajectoryPoint_"):
    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Duration


@dataclass
class Trajectory(IdlStruct, typename="trajectory_msgs.msg.dds_.JointTrajectory_"):
    header: Header
    joint_names: sequence[str]
    points: sequence[Point]


@dataclass
class Gid(IdlStruct, typename="rmw_dds_common.msg.dds_.Gid_"):
    data: array[uint8, 16]


@dataclass
class NodeEntities(IdlStruct, typename="rmw_dds_common.msg.dds_.NodeEntitiesInfo_"):
    node_namespace: str
    node_name: str
    reader_gid_seq: sequence[Gid]
    writer_gid_seq: sequence[Gid]


@dataclass
class ParticipantEntities(IdlStruct, typename="rmw_dds_common.msg.dds_.ParticipantEntitiesInfo_"):
    gid: Gid
    node_entities_info_seq: sequence[NodeEntities]


# A service of rmw_cyclonedds_cpp: its samples begin with who asks and which request it is.
@dataclass
class SetBoolRequest(IdlStruct, typename="std_srvs.srv.dds_.SetBool_Request_"):
    guid: uint64
    number: int64
    data: bool


@dataclass
class SetBoolResponse(IdlStruct, typename="std_srvs.srv.dds_.SetBool_Response_"):
    guid: uint64
    number: int64
    success: bool
    message: str


TYPES = {
    "std_msgs/msg/String": String,
    "trajectory_msgs/msg/JointTrajectory": Trajectory,
}


SAYING = threading.Lock()


def say(**what):
    # Listeners of Cyclone DDS report from threads of their own, and print writes the end of the line separately.
    with SAYING:
        print(json.dumps(what), flush=True)


def plain(value):
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def message(cls, data):
    fields = {}
    for name, kind in cls.__annotations__.items():
        if name in data:
            fields[name] = value(kind, data[name])
    return cls(**fields)


def value(kind, data):
    if isinstance(data, dict):
        return message(kind, data)
    if isinstance(data, list) and data and isinstance(data[0], dict):
        return [message(Point, item) for item in data]
    return data


def qos(text):
    """As in `peer.py`: "reliable", "best_effort", "latched", each with a depth if wanted."""
    kind, _, depth = (text or "reliable").partition(":")
    return Qos(
        Policy.Reliability.BestEffort if kind == "best_effort" else Policy.Reliability.Reliable(duration(seconds=1)),
        Policy.Durability.TransientLocal if kind == "latched" else Policy.Durability.Volatile,
        Policy.History.KeepLast(int(depth or 10)),
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )


# Numbers of DDS for its policies.
POLICIES = {2: "DURABILITY", 11: "RELIABILITY"}


class Told(Listener):
    """Tells when an endpoint cannot be matched because of its quality of service."""

    def __init__(self, topic):
        super().__init__()
        self.topic = topic

    def on_requested_incompatible_qos(self, reader, status):
        say(event="incompatible", topic=self.topic, policy=POLICIES.get(status.last_policy_id, status.last_policy_id))

    def on_offered_incompatible_qos(self, writer, status):
        say(event="incompatible", topic=self.topic, policy=POLICIES.get(status.last_policy_id, status.last_policy_id))


class Peer:
    def __init__(self):
        self.participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
        self.publisher, self.subscriber = Publisher(self.participant), Subscriber(self.participant)
        self.writers, self.readers, self.counts, self.kept = {}, {}, {}, []
        self.endpoints = {
            kind: BuiltinDataReader(self.participant, topic)
            for kind, topic in (("publishers", BuiltinTopicDcpsPublication), ("subscribers", BuiltinTopicDcpsSubscription))
        }
        self.nodes = DataReader(self.subscriber, Topic(self.participant, "ros_discovery_info", ParticipantEntities), qos=qos("latched:1"))
        self.participants = {}
        self.commands, self.waiting, self.running = queue.Queue(), [], True
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in sys.stdin:
            self.commands.put(json.loads(line))
        self.commands.put({"op": "quit", "id": 0})

    def spin(self):
        say(event="ready")
        while self.running:
            try:
                self.order(self.commands.get(timeout=0.005))
            except queue.Empty:
                pass
            self.look()

    def order(self, command):
        try:
            answer = getattr(self, "op_" + command["op"])(command)
        except Exception as error:  # whatever goes wrong is the test's to judge
            say(id=command["id"], ok=False, error=f"{type(error).__name__}: {error}")
            return
        if callable(answer):
            self.waiting.append((command, answer, time.monotonic() + command.get("timeout", PATIENCE_S)))
        elif answer is not None:
            say(id=command["id"], ok=True, **answer)

    def look(self):
        for topic, (reader, kind) in self.readers.items():
            for sample in reader.take(N=100):
                # What is no sample tells of a publisher that has gone.
                if isinstance(sample, kind):
                    self.counts[topic] += 1
                    say(event="message", topic=topic, n=self.counts[topic], data=plain(sample))
        for sample in self.nodes.take(N=100):
            if isinstance(sample, ParticipantEntities):
                self.participants[bytes(sample.gid.data)] = sample.node_entities_info_seq
        for entry in list(self.waiting):
            command, answer, deadline = entry
            found = answer()
            if found is not None:
                say(id=command["id"], ok=True, **found)
            elif time.monotonic() > deadline:
                say(id=command["id"], ok=False, error=f"timed out: {command}")
            else:
                continue
            self.waiting.remove(entry)

    # --- topics, by their ROS names

    def topic(self, name, kind):
        topic = Topic(self.participant, "rt" + name, TYPES[kind])
        self.kept.append(topic)
        return topic

    def op_advertise(self, c):
        topic = self.topic(c["topic"], c["type"])
        self.writers[c["topic"]] = DataWriter(self.publisher, topic, qos=qos(c.get("qos")), listener=Told(c["topic"])), TYPES[c["type"]]
        return {}

    def op_publish(self, c):
        writer, kind = self.writers[c["topic"]]
        writer.write(message(kind, c["data"]))
        return {}

    def op_subscribe(self, c):
        topic = self.topic(c["topic"], c["type"])
        self.counts[c["topic"]] = 0
        reader = DataReader(self.subscriber, topic, qos=qos(c.get("qos")), listener=Told(c["topic"]))
        self.readers[c["topic"]] = reader, TYPES[c["type"]]
        return {}

    def op_received(self, c):
        at_least = c.get("at_least", 0)
        return lambda: {"n": self.counts[c["topic"]]} if self.counts[c["topic"]] >= at_least else None

    def op_wait_matched(self, c):
        writer, _ = self.writers[c["topic"]]
        return lambda: {} if len(writer.get_matched_subscriptions()) >= c.get("n", 1) else None

    def op_wait_subscribed(self, c):
        """Each side finds the other at its own time: a publisher that has matched may still be unheard."""
        reader, _ = self.readers[c["topic"]]
        return lambda: {} if len(reader.get_matched_publications()) >= c.get("n", 1) else None

    # --- the graph

    def found(self, kind):
        return [e for e in self.endpoints[kind].read(N=10000) if hasattr(e, "topic_name") and alive(e)]

    def op_endpoints(self, c):
        """Of a topic by its ROS name, in ROS's words."""
        def told(e):
            reliable = isinstance(e.qos[Policy.Reliability], type(Policy.Reliability.Reliable(0)))
            latched = e.qos[Policy.Durability] == Policy.Durability.TransientLocal
            return {
                "type": e.type_name.replace("::dds_::", "::").replace("::", "/").rstrip("_"),
                "reliability": "RELIABLE" if reliable else "BEST_EFFORT",
                "durability": "TRANSIENT_LOCAL" if latched else "VOLATILE",
            }

        return {kind: [told(e) for e in self.found(kind) if e.topic_name == "rt" + c["topic"]] for kind in self.endpoints}

    def names(self):
        return [n.node_namespace.rstrip("/") + "/" + n.node_name for nodes in self.participants.values() for n in nodes]

    def op_wait_node(self, c):
        name = c.get("namespace", "/").rstrip("/") + "/" + c["name"]
        return lambda: {} if name in self.names() else None

    def op_wait_gone(self, c):
        """Until a node and every endpoint below a prefix of names have left the graph."""
        name = c.get("namespace", "/").rstrip("/") + "/" + c["name"]

        def look():
            names = [e.topic_name[2:] for kind in self.endpoints for e in self.found(kind)]
            return None if name in self.names() or any(n.startswith(c["prefix"]) for n in names) else {}

        return look

    def op_call_yourself(self, c):
        """Tells the graph that this participant is a node."""
        topic = Topic(self.participant, "ros_discovery_info", ParticipantEntities)
        writer = DataWriter(self.publisher, topic, qos=qos("latched:1"))
        gid = Gid(data=list(self.participant.guid.bytes))
        node = NodeEntities(node_namespace=c["namespace"], node_name=c["name"], reader_gid_seq=[], writer_gid_seq=[])
        writer.write(ParticipantEntities(gid=gid, node_entities_info_seq=[node]))
        self.kept += [topic, writer]
        return {}

    # --- a service, as rmw_cyclonedds_cpp calls and offers it

    def op_call(self, c):
        requests = Topic(self.participant, "rq" + c["service"] + "Request", SetBoolRequest)
        replies = Topic(self.participant, "rr" + c["service"] + "Reply", SetBoolResponse)
        writer, reader = DataWriter(self.publisher, requests, qos=qos(None)), DataReader(self.subscriber, replies, qos=qos(None))
        self.kept += [requests, replies, writer, reader]
        state = {}

        def look():
            if "asked" not in state:
                if writer.get_matched_subscriptions() and reader.get_matched_publications():
                    state["asked"] = True
                    writer.write(SetBoolRequest(guid=0x1122334455667788, number=7, **c["request"]))
                return None
            for reply in reader.take(N=100):
                if isinstance(reply, SetBoolResponse) and (reply.guid, reply.number) == (0x1122334455667788, 7):
                    return {"response": {"success": reply.success, "message": reply.message}}
            return None

        return look

    def op_serve(self, c):
        requests = Topic(self.participant, "rq" + c["service"] + "Request", SetBoolRequest)
        replies = Topic(self.participant, "rr" + c["service"] + "Reply", SetBoolResponse)
        reader, writer = DataReader(self.subscriber, requests, qos=qos(None)), DataWriter(self.publisher, replies, qos=qos(None))
        self.kept += [requests, replies, writer, reader]
        response = c["response"]

        def look():
            for request in reader.take(N=100):
                if isinstance(request, SetBoolRequest):
                    say(event="request", service=c["service"], data={"data": request.data})
                    writer.write(SetBoolResponse(guid=request.guid, number=request.number, **response))
            return None

        self.waiting.append(({"id": 0}, look, float("inf")))
        return {}

    # --- the peer itself

    def op_now(self, _):
        return {"now": time.time_ns()}

    def op_quit(self, _):
        self.running = False


def alive(sample):
    info = getattr(sample, "sample_info", None)
    # Instance state 16: there, and not disposed or without a writer.
    return info is None or info.instance_state == 16


def main():
    peer = Peer()
    peer.spin()
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
