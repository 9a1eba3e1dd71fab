# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Ethernet cable between two network namespaces that loses, delays, reorders and repeats frames, or is unplugged.

usage: cable.py NAMESPACE NAMESPACE

Both ends are TAP devices with the name `cable`. Kernels without netem have no queueing discipline for this. Each line on standard input is a
JSON object with new settings; the answer is a JSON object with the frames that were counted since the line before:

    {"loss": 0.05, "delay_s": 0.02, "reorder": 0.02, "duplicate": 0.02}     shares of all frames; a reordered frame is not delayed
    {"plugged": false}                                                       both ends lose their carrier, frames are lost

The end of standard input ends it.
"""
import fcntl
import heapq
import json
import os
import random
import selectors
import struct
import subprocess
import sys
import time

TUNSETIFF = 0x400454CA
TUNSETCARRIER = 0x400454E2
IFF_TAP, IFF_NO_PI = 0x0002, 0x1000
LONGEST_FRAME = 65536
COUNTERS = ("passed", "lost", "reordered", "duplicated", "unplugged")


def end_in(namespace, number):
    """Makes one end of the cable; it stays ours after it has moved to the namespace."""
    name = f"cw{os.getpid()}.{number}"
    end = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(end, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TAP | IFF_NO_PI))
    subprocess.run(["ip", "link", "set", name, "netns", namespace, "name", "cable"], check=True)
    return end


class Cable:
    def __init__(self, namespaces):
        first, second = (end_in(namespace, number) for number, namespace in enumerate(namespaces))
        self.other = {first: second, second: first}
        self.settings = {"loss": 0.0, "delay_s": 0.0, "reorder": 0.0, "duplicate": 0.0, "plugged": True}
        self.random = random.Random(1)
        self.waiting = []
        self.number = 0
        self.counts = dict.fromkeys(COUNTERS, 0)

    def set(self, settings):
        unknown = settings.keys() - self.settings.keys()
        if unknown:
            raise ValueError(f"unknown settings {sorted(unknown)}; known are {sorted(self.settings)}")
        self.settings.update(settings)
        if "plugged" in settings:
            self.waiting.clear()
            for end in self.other:
                fcntl.ioctl(end, TUNSETCARRIER, struct.pack("i", int(settings["plugged"])))
        counts, self.counts = self.counts, dict.fromkeys(COUNTERS, 0)
        return counts

    def write(self, end, frame):
        try:
            os.write(end, frame)
            self.counts["passed"] += 1
        except OSError:
            # The device is not up.
            self.counts["unplugged"] += 1

    def chance(self, name):
        return self.random.random() < self.settings[name]

    def take(self, end):
        """Takes the frames that wait at an end."""
        other, settings = self.other[end], self.settings
        while True:
            try:
                frame = os.read(end, LONGEST_FRAME)
            except OSError:
                return
            if not settings["plugged"]:
                self.counts["unplugged"] += 1
                continue
            if self.chance("loss"):
                self.counts["lost"] += 1
                continue
            copies = 1
            if self.chance("duplicate"):
                self.counts["duplicated"] += 1
                copies = 2
            for _ in range(copies):
                if settings["delay_s"] <= 0.0:
                    self.write(other, frame)
                elif self.chance("reorder"):
                    self.counts["reordered"] += 1
                    self.write(other, frame)
                else:
                    self.number += 1
                    heapq.heappush(self.waiting, (time.monotonic() + settings["delay_s"], self.number, other, frame))

    def deliver(self):
        """Delivers the frames that are due; returns the time until the next one."""
        while self.waiting:
            left = self.waiting[0][0] - time.monotonic()
            if left > 0.0:
                return left
            _, _, end, frame = heapq.heappop(self.waiting)
            self.write(end, frame)
        return None


def main():
    cable = Cable(sys.argv[1:3])
    selector = selectors.DefaultSelector()
    for end in cable.other:
        selector.register(end, selectors.EVENT_READ)
    selector.register(sys.stdin.fileno(), selectors.EVENT_READ)
    print("{}", flush=True)
    lines = b""
    while True:
        for key, _ in selector.select(cable.deliver()):
            if key.fd in cable.other:
                cable.take(key.fd)
                continue
            text = os.read(key.fd, 4096)
            if not text:
                return
            *whole, lines = (lines + text).split(b"\n")
            for line in whole:
                print(json.dumps(cable.set(json.loads(line))), flush=True)


main()
