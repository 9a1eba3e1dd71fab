# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A twin of our nodes on Cyclone DDS, for `latency`, called like `rclpy_twin.py`. Topics and services are written out as ROS 2 has them
on the wire and as `rmw_cyclonedds_cpp` makes them; an action's goal is asked for by a service of its own, which is what is answered here.
"""

import importlib.metadata
import json
import os
import sys
import threading
import time
from dataclasses import dataclass

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int64, sequence, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from cyclone_peer import SetBoolRequest, SetBoolResponse, Time, Trajectory, qos


@dataclass
class Latch(IdlStruct, typename="camwright_msgs.msg.dds_.Latch_"):
    tick: uint64
    input: str
    rising: bool
    joint: str
    counts: int64


@dataclass
class MachineStream(IdlStruct, typename="camwright_msgs.msg.dds_.MachineStream_"):
    stamp: Time
    epoch: Time
    tick: uint64
    credit_tick: uint64
    pace: uint8
    motion: uint8
    commands_received: uint32
    holder: str
    alarms: sequence[uint16]
    setpoint_counts: sequence[int64]
    actual_counts: sequence[int64]
    actual_velocities: sequence[float64]
    latches: sequence[Latch]


@dataclass
class MachineIo(IdlStruct, typename="camwright_msgs.msg.dds_.MachineIo_"):
    stamp: Time
    tick: uint64
    origin: bool
    station_switches: sequence[str]
    station_states: sequence[bool]
    other_inputs: sequence[str]
    other_states: sequence[bool]
    overtravel_x_min: bool
    overtravel_x_max: bool
    overtravel_z_min: bool
    overtravel_z_max: bool
    estop: bool
    drives_on: bool
    wheel_running: bool
    part_present: bool


@dataclass
class SendGoalRequest(IdlStruct, typename="camwright_msgs.action.dds_.RunJob_SendGoal_Request_"):
    guid: uint64
    number: int64
    goal_id: array[uint8, 16]
    job: str
    overrides: sequence[str]
    start_lobe: str


@dataclass
class SendGoalResponse(IdlStruct, typename="camwright_msgs.action.dds_.RunJob_SendGoal_Response_"):
    guid: uint64
    number: int64
    accepted: bool
    stamp: Time


STAMP = slice(4, 12)
TOPICS = {
    "setpoints": (("rt/twin/setpoints", Trajectory), ("rt/twin/stream", MachineStream)),
    "edge": (("rt/twin/io", MachineIo), ("rt/twin/stop", Trajectory)),
}
ESTOP = (("rq/twin/estopRequest", SetBoolRequest), ("rr/twin/estopReply", SetBoolResponse))
SEND_GOAL = (
    ("rq/twin/run_job/_action/send_goalRequest", SendGoalRequest),
    ("rr/twin/run_job/_action/send_goalReply", SendGoalResponse),
)


class Twin:
    """Readers that wait together, each with what is done with its samples."""

    def __init__(self):
        self.participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
        self.waitset = WaitSet(self.participant)
        self.served = []

    def writer(self, topic):
        return DataWriter(self.participant, Topic(self.participant, *topic), qos=qos("reliable:1000"))

    def reader(self, topic, take):
        reader = DataReader(self.participant, Topic(self.participant, *topic), qos=qos("reliable:1000"))
        condition = ReadCondition(reader, ViewState.Any | SampleState.NotRead | InstanceState.Alive)
        self.waitset.attach(condition)
        self.served.append((reader, condition, take))
        return reader

    def spin_once(self, seconds):
        if self.waitset.wait(duration(seconds=seconds)):
            for reader, _, take in self.served:
                take(reader)


def raw(each):
    """Takes samples as they are on the wire."""

    def take(reader):
        taken = ddspy_take(reader._ref, ViewState.Any | SampleState.Any | InstanceState.Any, 100)
        for data, info in taken if isinstance(taken, list) else []:
            if info.valid_data:
                each(bytes(data))

    return take


def typed(kind, each):
    def take(reader):
        for sample in reader.take(N=100):
            if isinstance(sample, kind):
                each(sample)

    return take


def stamped(message, stamp):
    message = message[: STAMP.start] + stamp + message[STAMP.stop :]
    return message.ljust(len(message) + 3 & ~3, b"\0")


def answer_topic(twin, question, answer, message):
    writer = twin.writer(answer)
    twin.reader(question, raw(lambda asked: ddspy_write(writer._ref, stamped(message, asked[STAMP]))))


def answer_service(twin, service, response):
    writer = twin.writer(service[1])
    twin.reader(service[0], typed(service[0][1], lambda asked: writer.write(response(asked))))


def answer(stream, stop):
    twin = Twin()
    answer_topic(twin, *TOPICS["setpoints"], stream)
    answer_topic(twin, *TOPICS["edge"], stop)
    answer_service(twin, ESTOP, lambda asked: SetBoolResponse(guid=asked.guid, number=asked.number, success=True, message=""))
    answer_service(
        twin,
        SEND_GOAL,
        lambda asked: SendGoalResponse(guid=asked.guid, number=asked.number, accepted=True, stamp=Time()),
    )
    threading.Thread(target=end_with_input, daemon=True).start()
    print(f"Cyclone DDS {importlib.metadata.version('cyclonedds')}", flush=True)
    while True:
        twin.spin_once(1.0)


def end_with_input():
    sys.stdin.read()
    os._exit(0)


def ask(messages, count):
    trips = {}
    for name, message in zip(TOPICS, messages):
        trips[name] = ask_topic(*TOPICS[name], message, count)
    trips["estop"] = ask_service(count)
    print(json.dumps(trips), flush=True)


def wait_matched(writer, reader):
    while not writer.get_matched_subscriptions() or not reader.get_matched_publications():
        time.sleep(0.01)


def trips_of(twin, ask_one, heard, count):
    """The first 20 are for everybody to find each other."""
    trips = []
    for number in range(1, count + 21):
        asked = time.monotonic_ns()
        ask_one(number)
        while number not in heard and time.monotonic_ns() < asked + 10**10:
            twin.spin_once(0.1)
        if number > 20 and number in heard:
            trips.append(heard[number] - asked)
        time.sleep(0.003)
    return trips


def ask_topic(question, answer, message, count):
    twin, heard = Twin(), {}
    writer = twin.writer(question)
    reader = twin.reader(answer, raw(lambda told: heard.setdefault(int.from_bytes(told[STAMP][:4], "little"), time.monotonic_ns())))
    wait_matched(writer, reader)
    stamp = lambda number: number.to_bytes(4, "little") + bytes(4)
    return trips_of(twin, lambda number: ddspy_write(writer._ref, stamped(message, stamp(number))), heard, count)


def ask_service(count):
    twin, heard = Twin(), {}
    writer = twin.writer(ESTOP[0])
    reader = twin.reader(ESTOP[1], typed(SetBoolResponse, lambda told: heard.setdefault(told.number, time.monotonic_ns())))
    wait_matched(writer, reader)
    return trips_of(twin, lambda number: writer.write(SetBoolRequest(guid=1, number=number, data=True)), heard, count)


def main():
    role, first, second, *count = sys.argv[1:]
    messages = bytes.fromhex(first), bytes.fromhex(second)
    if role == "answer":
        answer(*messages)
    else:
        ask(messages, int(count[0]))
    sys.stdout.flush()
    os._exit(0)


main()
