# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Measures `upstream_server` from real ROS 2 (rclpy, Fast DDS); needs a shell with ROS 2.

    fast_dds_peer.py calls [N] [SERVICE]  first call of each of N fresh participants and of N fresh clients (std_srvs/srv/Trigger)
    fast_dds_peer.py replies              replies of growing length
    fast_dds_peer.py large [N]            N messages of 1 MB
"""

import os
import sys
import time

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String
from std_srvs.srv import Trigger

LENGTHS = [100, 1_000, 1_300, 1_500, 4_000, 30_000, 60_000, 70_000, 300_000]


class Participant:
    def __init__(self, name):
        self.context = Context()
        rclpy.init(args=[], context=self.context)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def call(self, client, patience):
        """Seconds of a call and its reply; none after `patience`."""
        begun = time.monotonic()
        future = client.call_async(Trigger.Request())
        self.executor.spin_until_future_complete(future, timeout_sec=patience)
        return time.monotonic() - begun, future.result() if future.done() else None

    def client(self, service):
        client = self.node.create_client(Trigger, service)
        if not client.wait_for_service(timeout_sec=20):
            sys.exit(f"no service {service} within 20 s")
        return client

    def end(self):
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def summary(what, seconds):
    seconds.sort()
    stalls, slow = sum(s > 1 for s in seconds), sum(0.05 < s <= 1 for s in seconds)
    median, last = seconds[len(seconds) // 2] * 1000, seconds[-1] * 1000
    print(f"{len(seconds)} {what}: {stalls} stalls above 1 s, {slow} above 50 ms, median {median:.1f} ms, maximum {last:.0f} ms", flush=True)


def calls(number=100, service="/upstream/reply_100"):
    seconds = []
    for index in range(int(number)):
        participant = Participant(f"fresh_{index}")
        seconds.append(participant.call(participant.client(service), 10)[0])
        participant.end()
    summary("fresh participants", seconds)
    participant, seconds = Participant("fresh_clients"), []
    for _ in range(int(number)):
        client = participant.client(service)
        seconds.append(participant.call(client, 10)[0])
        participant.node.destroy_client(client)
    summary("fresh clients of one participant", seconds)


def replies():
    participant = Participant("replies")
    for length in LENGTHS:
        client = participant.client(f"/upstream/reply_{length}")
        seconds, reply = participant.call(client, 5)
        arrived = reply is not None and len(reply.message) == length
        print(f"{length} octets: " + (f"{seconds * 1000:.1f} ms" if arrived else f"no reply within {seconds:.0f} s"), flush=True)


def large(number=10):
    participant, received = Participant("large"), []
    arrived = lambda message: received.append((time.time() - float(message.data[:20])) * 1000)
    participant.node.create_subscription(String, "/upstream/large", arrived, 10)
    publish = participant.client("/upstream/publish")
    deadline = time.monotonic() + 20
    while participant.node.count_publishers("/upstream/large") == 0 and time.monotonic() < deadline:
        participant.executor.spin_once(timeout_sec=0.05)
    for index in range(int(number)):
        participant.call(publish, 10)
        deadline = time.monotonic() + 15
        while len(received) <= index and time.monotonic() < deadline:
            participant.executor.spin_once(timeout_sec=0.05)
    print("1 MB in ms: " + " ".join(f"{ms:.0f}" for ms in received), flush=True)


{"calls": calls, "replies": replies, "large": large}[sys.argv[1]](*sys.argv[2:])
# Teardown of rclpy takes seconds.
sys.stdout.flush()
os._exit(0)
