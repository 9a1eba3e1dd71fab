# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A twin of our nodes on rclpy and Fast DDS, for `latency`: answers what they answer, and does nothing else.

    rclpy_twin.py answer STREAM STOP      answers until its standard input ends
    rclpy_twin.py ask CHUNK EDGE COUNT    asks such a responder COUNT times each; prints the round trips (ns) as JSON

STREAM, STOP, CHUNK, EDGE are messages as hexadecimal CDR. All of them begin with a stamp, which an answer has from its question. They
stay bytes on both sides, so that nothing that Python does with messages is counted.
"""

import importlib.metadata
import json
import os
import sys
import threading
import time

import rclpy
from camwright_msgs.action import RunJob
from camwright_msgs.msg import MachineIo, MachineStream
from rclpy.action import ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

QOS = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1000, reliability=ReliabilityPolicy.RELIABLE)
# Where the stamp stands: after the four bytes that say how the message is encoded.
STAMP = slice(4, 12)
# Topics with their types: question and answer.
TOPICS = {
    "setpoints": (("twin/setpoints", JointTrajectory), ("twin/stream", MachineStream)),
    "edge": (("twin/io", MachineIo), ("twin/stop", JointTrajectory)),
}


def stamped(message, stamp):
    return message[: STAMP.start] + stamp + message[STAMP.stop :]


def answer_topic(node, question, answer, message):
    publisher = node.create_publisher(answer[1], answer[0], QOS)

    def answered(asked):
        publisher.publish(stamped(message, bytes(asked[STAMP])))

    node.create_subscription(question[1], question[0], answered, QOS, raw=True)


def answer(stream, stop):
    node = rclpy.create_node("twin")
    answer_topic(node, *TOPICS["setpoints"], stream)
    answer_topic(node, *TOPICS["edge"], stop)

    def pressed(request, response):
        response.success = True
        return response

    def run(goal):
        goal.succeed()
        return RunJob.Result()

    node.create_service(SetBool, "twin/estop", pressed)
    kept = ActionServer(node, RunJob, "twin/run_job", run)
    threading.Thread(target=end_with_input, daemon=True).start()
    print(f"rclpy {importlib.metadata.version('ros-jazzy-rclpy')} on Fast DDS", flush=True)
    rclpy.spin(node)
    del kept


def end_with_input():
    sys.stdin.read()
    os._exit(0)


def ask(messages, count):
    node, executor = rclpy.create_node("asker"), SingleThreadedExecutor()
    # Added once: functions of `rclpy` itself that spin a node do that for every call, which takes longer and longer.
    executor.add_node(node)
    trips = {}
    for name, message in zip(TOPICS, messages):
        trips[name] = ask_topic(node, executor, *TOPICS[name], message, count)
    trips["estop"] = ask_service(node, executor, count)
    print(json.dumps(trips), flush=True)


def trips_of(executor, ask_one, heard, count):
    """The first 20 are for everybody to find each other."""
    trips = []
    for number in range(1, count + 21):
        asked = time.monotonic_ns()
        ask_one(number)
        while number not in heard and time.monotonic_ns() < asked + 10**10:
            executor.spin_once(timeout_sec=0.1)
        if number > 20 and number in heard:
            trips.append(heard[number] - asked)
        time.sleep(0.003)
    return trips


def ask_topic(node, executor, question, answer, message, count):
    heard = {}

    def told(answered):
        heard.setdefault(int.from_bytes(answered[STAMP][:4], "little"), time.monotonic_ns())

    publisher = node.create_publisher(question[1], question[0], QOS)
    node.create_subscription(answer[1], answer[0], told, QOS, raw=True)
    while not publisher.get_subscription_count() or not node.count_publishers(node.resolve_topic_name(answer[0])):
        executor.spin_once(timeout_sec=0.01)
    publish = lambda number: publisher.publish(stamped(message, number.to_bytes(4, "little") + bytes(4)))
    return trips_of(executor, publish, heard, count)


def ask_service(node, executor, count):
    heard = {}
    client = node.create_client(SetBool, "twin/estop")
    client.wait_for_service()

    def call(number):
        future = client.call_async(SetBool.Request(data=True))
        future.add_done_callback(lambda _: heard.setdefault(number, time.monotonic_ns()))

    return trips_of(executor, call, heard, count)


def main():
    role, first, second, *count = sys.argv[1:]
    rclpy.init(args=[])
    messages = bytes.fromhex(first), bytes.fromhex(second)
    if role == "answer":
        answer(*messages)
    else:
        ask(messages, int(count[0]))
    sys.stdout.flush()
    # rclpy's teardown takes seconds, and nobody waits for what it would tidy.
    os._exit(0)


main()
