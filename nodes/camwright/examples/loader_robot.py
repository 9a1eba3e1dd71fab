#!/usr/bin/env python3
# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A robot that loads the machine, in rclpy: what loader_robot.rs does, for whoever writes a robot's side in Python.

    loader_robot.py [--job JOB] [--parts N] [--set KEY=VALUE ...] [--namespace NS]

Needs rclpy and the built camwright_msgs. Says ten times a second where it is (`loader/state`), does what `job_planner/loading` asks for, works
the chuck by `job_planner/open_chuck` and `/close_chuck`, and in the place of a gripper calls `machine/place_part` and `/take_part`. RESET and
START it says as an operator or a line would. A real robot goes where `enter` and `leave` only say that it is.
"""

import argparse
import sys
import threading
import time

import rclpy
from camwright_msgs.msg import CellState, LoaderState, LoadingState
from camwright_msgs.srv import CellCommand, TakeCommand
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

# How long anybody may take to answer, and how often the robot says where it is.
ANSWER_S = 90.0
SIGNALS_S = 0.1
# Lease of command; a run that is under way keeps it.
LEASE_S = 600.0


class Refused(Exception):
    """Somebody said no, or nothing in time; the text says what."""


class Robot:
    def __init__(self, node, raw_parts):
        self.node = node
        self.news = threading.Condition()
        self.cell = None
        self.loading = None
        self.signals = LoaderState(name="loader", available=True, parts_left=raw_parts)
        latched = QoSProfile(
            depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        node.create_subscription(CellState, "job_planner/cell_state", self.hear_cell, latched)
        node.create_subscription(LoadingState, "job_planner/loading", self.hear_loading, latched)
        self.publisher = node.create_publisher(LoaderState, "loader/state", 10)
        node.create_timer(SIGNALS_S, self.say)
        self.take = node.create_client(TakeCommand, "machine/take_command")
        self.command = node.create_client(CellCommand, "job_planner/cell_command")
        names = ["job_planner/open_chuck", "job_planner/close_chuck", "machine/place_part", "machine/take_part"]
        self.steps = {name: node.create_client(Trigger, name) for name in names}

    def hear_cell(self, message):
        with self.news:
            self.cell = message
            self.news.notify_all()

    def hear_loading(self, message):
        with self.news:
            self.loading = message
            self.news.notify_all()

    def say(self):
        self.signals.stamp = self.node.get_clock().now().to_msg()
        self.publisher.publish(self.signals)

    def signal(self, **changes):
        for name, value in changes.items():
            setattr(self.signals, name, value)
        self.say()

    def wait(self, what, wanted):
        """What `wanted` finds in what was heard, as soon as it finds something."""
        deadline = time.monotonic() + ANSWER_S
        with self.news:
            while not (found := wanted()):
                left = deadline - time.monotonic()
                if left <= 0:
                    state = self.cell and (self.cell.state_name, self.cell.substate, self.cell.stop_reason)
                    raise Refused(f"waited {ANSWER_S:.0f} s for {what}; the cell is {state}")
                self.news.wait(left)
            return found

    def call(self, client, request):
        if not client.wait_for_service(ANSWER_S):
            raise Refused(f"{client.srv_name} is not there")
        answered = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: answered.set())
        if not answered.wait(ANSWER_S):
            raise Refused(f"{client.srv_name} does not answer")
        response = future.result()
        if not response.success:
            raise Refused(f"{client.srv_name}: {response.message}")

    def step(self, name):
        self.call(self.steps[name], Trigger.Request())

    def enter(self):
        """Enters as soon as it may; what it enters for."""
        cleared = self.wait("a leave to enter", lambda: self.loading if self.may_enter() else None)
        self.signal(busy=True, in_work_area=True)
        self.wait("the machine to see it", lambda: self.loading.robot_in_work_area and self.loading.step == "inside")
        return cleared.request

    def may_enter(self):
        return self.loading is not None and self.loading.clear_to_enter

    def change_part(self, request):
        self.step("job_planner/open_chuck")
        if request != LoadingState.LOAD:
            self.step("machine/take_part")
        if request != LoadingState.UNLOAD:
            self.step("machine/place_part")
            self.step("job_planner/close_chuck")
            self.signal(parts_left=max(self.signals.parts_left - 1, 0))

    def leave(self):
        self.signal(busy=False, in_work_area=False)
        self.wait("the end of the leave", lambda: not self.loading.clear_to_enter)

    def tend(self):
        """Tends the cell until its run is complete; how often it went in."""
        visits = 0
        while True:
            over = [CellState.COMPLETE, CellState.HELD, CellState.STOPPED, CellState.ABORTED]
            self.wait("a request", lambda: self.may_enter() or (self.cell and self.cell.state in over))
            if not self.may_enter():
                if self.cell.state != CellState.COMPLETE:
                    raise Refused(f"the cell is {self.cell.state_name}: {self.cell.stop_reason}")
                return visits
            request = self.enter()
            try:
                self.change_part(request)
            finally:
                # Whatever happened, it comes out before it says so.
                self.leave()
            visits += 1

    def command_lease(self, release=False):
        """Shared, so that an operator may command beside the robot."""
        return TakeCommand.Request(holder="loader robot", lease_s=LEASE_S, shared=True, release=release)

    def start_run(self, job, overrides, parts):
        self.call(self.take, self.command_lease())
        self.call(self.command, CellCommand.Request(command=CellCommand.Request.RESET))
        self.wait("the cell to be idle", lambda: self.cell and self.cell.state == CellState.IDLE)
        start = CellCommand.Request(command=CellCommand.Request.START, parts=parts, job=job, overrides=overrides)
        self.call(self.command, start)
        # What is heard from now on is of this run.
        self.wait("the run to begin", lambda: self.cell.state != CellState.IDLE)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--job", default="", help="job file; empty: the loaded one")
    parser.add_argument("--parts", type=int, default=10)
    parser.add_argument("--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--namespace", default="")
    arguments = parser.parse_args()
    rclpy.init(args=[])
    node = rclpy.create_node("loader_robot", namespace=arguments.namespace)
    robot = Robot(node, arguments.parts)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    spin = threading.Thread(target=executor.spin, daemon=True)
    spin.start()
    try:
        robot.start_run(arguments.job, arguments.overrides, arguments.parts)
        visits = robot.tend()
        # What another shares stays with it.
        robot.take.call_async(robot.command_lease(release=True))
        print(f"{robot.cell.parts_done} of {arguments.parts} parts tended in {visits} visits", flush=True)
        return 0
    except Refused as refused:
        print(f"loader_robot: {refused}", file=sys.stderr, flush=True)
        return 1
    finally:
        executor.shutdown()
        spin.join()
        node.destroy_node()
        rclpy.shutdown()


if __name__ == "__main__":
    sys.exit(main())
