# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A publisher of another DDS for `recorder_load`: `std_msgs/msg/String` of a given length, numbered from 1 in the text.

    publish.py cyclone|rclpy TOPIC OCTETS best_effort|reliable

Says who it is; then `matched` once somebody is subscribed. A line `RATE SECONDS` on its standard input makes it publish: in bursts, a
thousand times a second what is due. It ends with some messages one by one, so that a gap before them shows in the numbers, and says
what it did in JSON. Then it stays, for whoever is to hear it still, until its standard input ends.

A reliable one keeps all that is not acknowledged and waits where that is too much; what could not be published is published again.
"""

import importlib.metadata
import json
import os
import resource
import sys
import time

# Messages at the end, and the pauses around them (s).
LAST, PAUSE_S = 20, 0.02
# Pause between two bursts (s).
BURST_S = 0.0005
# Where the number stands: after the four bytes that say how the message is encoded, and the length of the text.
HEAD = 8


class Cyclone:
    def __init__(self, topic, reliability):
        from cyclone_peer import String
        from cyclonedds._clayer import ddspy_write
        from cyclonedds.core import Policy, Qos
        from cyclonedds.domain import DomainParticipant
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic
        from cyclonedds.util import duration

        reliable = Policy.Reliability.Reliable(duration(seconds=1))
        qos = Qos(
            Policy.Reliability.BestEffort if reliability == "best_effort" else reliable,
            Policy.Durability.Volatile,
            Policy.History.KeepAll,
            Policy.DataRepresentation(use_cdrv0_representation=True),
        )
        self.participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
        self.writer = DataWriter(self.participant, Topic(self.participant, f"rt{topic}", String), qos=qos)
        self.name = f"Cyclone DDS {importlib.metadata.version('cyclonedds')}"
        reference = self.writer._ref
        self.publish = lambda message: ddspy_write(reference, message) == 0

    def matched(self):
        return len(self.writer.get_matched_subscriptions())


class Rclpy:
    def __init__(self, topic, reliability):
        import rclpy
        from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
        from std_msgs.msg import String

        kind = ReliabilityPolicy.BEST_EFFORT if reliability == "best_effort" else ReliabilityPolicy.RELIABLE
        rclpy.init(args=[])
        self.node = rclpy.create_node("load")
        self.publisher = self.node.create_publisher(String, topic, QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=kind))
        self.name = f"rclpy {importlib.metadata.version('ros-jazzy-rclpy')} on Fast DDS"
        self.refused = Exception

    def publish(self, message):
        try:
            self.publisher.publish(message)
            return True
        except Exception:
            # No room: whoever listens has not acknowledged enough.
            return False

    def matched(self):
        return self.publisher.get_subscription_count()


def messages(octets):
    """Makes the message with a number: text of ten digits, dots behind it."""
    length = octets - HEAD
    head = bytes((0, 1, 0, 0)) + length.to_bytes(4, "little")
    tail = b"." * (length - 11) + b"\0" + bytes(-octets % 4)
    return lambda number: b"%b%010d%b" % (head, number, tail)


def publish(stack, message, rate, seconds):
    write, total, number, refused = stack.publish, rate * seconds, 0, 0

    def up_to(due):
        nonlocal number, refused
        while number < due:
            if write(message(number + 1)):
                number += 1
            else:
                refused += 1

    begun = time.monotonic_ns()
    while number < total:
        up_to(min(total, (time.monotonic_ns() - begun) * rate // 10**9))
        time.sleep(BURST_S)
    took = (time.monotonic_ns() - begun) / 1e9
    time.sleep(25 * PAUSE_S)
    for _ in range(LAST):
        up_to(number + 1)
        time.sleep(PAUSE_S)
    used = resource.getrusage(resource.RUSAGE_SELF)
    return {"sent": number, "refused": refused, "took_s": took, "cpu_s": used.ru_utime + used.ru_stime}


def main():
    kind, topic, octets, reliability = sys.argv[1:]
    stack = {"cyclone": Cyclone, "rclpy": Rclpy}[kind](topic, reliability)
    print(stack.name, flush=True)
    while not stack.matched():
        time.sleep(0.01)
    print("matched", flush=True)
    rate, seconds = sys.stdin.readline().split()
    print(json.dumps(publish(stack, messages(int(octets)), int(rate), int(seconds))), flush=True)
    sys.stdin.read()
    os._exit(0)


main()
