# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A recorder as rosbag2 makes them, in Python, for `recorder_load`: a subscription of rclpy whose messages stay bytes, and the writer of
the package `mcap` with rosbag2's chunks, check sums and no compression.

    record.py TOPIC BAG best_effort|reliable DEPTH

Says `ready` once a publisher is there; at a line on its standard input it closes the bag and says in JSON what it received and wrote.
"""

import json
import os
import select
import sys
import time

import rclpy
from mcap.writer import CompressionType, Writer
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

CHUNK = 786_432
DEFINITION = "string data\n"


def main():
    topic, bag, reliability, depth = sys.argv[1:]
    kind = ReliabilityPolicy.BEST_EFFORT if reliability == "best_effort" else ReliabilityPolicy.RELIABLE
    rclpy.init(args=[])
    node, executor = rclpy.create_node("recorder"), SingleThreadedExecutor()
    executor.add_node(node)
    os.makedirs(bag)
    with open(os.path.join(bag, os.path.basename(bag) + "_0.mcap"), "wb") as file:
        writer = Writer(file, chunk_size=CHUNK, compression=CompressionType.NONE)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", DEFINITION.encode())
        channel = writer.register_channel(topic, "cdr", schema)
        counts = {"received": 0, "written": 0}

        def take(message):
            counts["received"] += 1
            now = time.time_ns()
            writer.add_message(channel, now, message, now, counts["received"])
            counts["written"] += 1

        def take_all(message):
            # What else is there is taken at once: an executor's round for each message takes longer than the message.
            take(message)
            with subscription.handle:
                while (more := subscription.handle.take_message(subscription.msg_type, True)) is not None:
                    take(more[0])

        qos = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=int(depth), reliability=kind)
        subscription = node.create_subscription(String, topic, take_all, qos, raw=True)
        while not node.count_publishers(topic):
            executor.spin_once(timeout_sec=0.01)
        print("ready", flush=True)
        while not select.select([sys.stdin], [], [], 0)[0]:
            executor.spin_once(timeout_sec=0.05)
        writer.finish()
    print(json.dumps(counts), flush=True)
    sys.stdin.read()
    os._exit(0)


main()
