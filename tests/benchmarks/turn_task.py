# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A task of the fastest turn as camwright/examples/turn_cases.rs writes it, and what any plan for it must keep."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TURN_RAD = 2.0 * np.pi
LIMITS = ("process bound", "C velocity", "X velocity", "C acceleration", "X acceleration", "C jerk", "X jerk")


@dataclass
class Task:
    """Path and bound at equal angles over one turn (mm over rad, rad/s), and the limits of C and X."""

    name: str
    input: str
    limits: dict
    x: np.ndarray
    x1: np.ndarray
    x2: np.ndarray
    x3: np.ndarray
    bound: np.ndarray
    # The turn that is judged.
    turn_s: float
    least_s: float
    speed: np.ndarray
    acceleration: np.ndarray
    # C and X of that turn at equal times.
    sample_s: float
    in_time: np.ndarray
    # 1/z of the largest z = (dC/dt)^2 that process and velocities allow.
    per_bound: np.ndarray = field(init=False)

    def __post_init__(self):
        limits = self.limits
        slope = (self.x1 / limits["x_velocity"]) ** 2
        self.per_bound = np.maximum(1.0 / np.minimum(self.bound, limits["c_velocity"]) ** 2, slope)

    @property
    def count(self):
        return len(self.x)

    @property
    def spacing(self):
        return TURN_RAD / self.count

    def ratios(self, z, first, second, at=slice(None)):
        """Largest share of each limit that a plan uses, from z, dz/dC and d2z/dC2 at points of the grid."""
        limits, x1, x2, x3 = self.limits, self.x1[at], self.x2[at], self.x3[at]
        speed = np.sqrt(z)
        uses = (
            speed / self.bound[at],
            speed / limits["c_velocity"],
            x1 * speed / limits["x_velocity"],
            0.5 * first / limits["c_acceleration"],
            (x2 * z + 0.5 * x1 * first) / limits["x_acceleration"],
            0.5 * speed * second / limits["c_jerk"],
            speed * (x3 * z + 1.5 * x2 * first + 0.5 * x1 * second) / limits["x_jerk"],
        )
        return np.array([np.max(np.abs(use)) for use in uses])


def excess(ratios):
    """Factor by which z is too large: velocity counts as its square, jerk as its cube's root squared."""
    powers = np.array([2, 2, 2, 1, 1, 2 / 3, 2 / 3])
    return float(np.max(ratios**powers))


def ratios_by_angle(task):
    """Uses of the turn that is judged: jerk by differencing its acceleration over the angle."""
    slope = (np.roll(task.acceleration, -1) - np.roll(task.acceleration, 1)) / (2.0 * task.spacing)
    return task.ratios(task.speed**2, 2.0 * task.acceleration, 2.0 * slope)


def ratios_in_time(task):
    """Uses of the turn that is judged: positions at equal times, differenced once, twice and three times."""
    limits, h = task.limits, task.sample_s
    c, x = task.in_time[:, 0], task.in_time[:, 1]
    largest = {}
    for axis, values in (("c", c), ("x", x)):
        for order, kind in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
            use = np.diff(values, order) / h**order / limits[f"{axis}_{kind}"]
            largest[axis, kind] = float(np.max(np.abs(use)))
    # Mean speed from sample to sample against the larger of the two bounds at its ends: a mean cannot be held to the smaller.
    bound = np.interp(np.mod(c, TURN_RAD), np.arange(task.count + 1) * task.spacing, np.append(task.bound, task.bound[0]))
    process = np.max(np.diff(c) / h / np.maximum(bound[1:], bound[:-1]))
    order = (("c", "velocity"), ("x", "velocity"), ("c", "acceleration"), ("x", "acceleration"), ("c", "jerk"), ("x", "jerk"))
    return np.array([float(process)] + [largest[key] for key in order])


def load(directory, index):
    """Reads a task of the example."""
    stem = Path(directory) / f"case_{index:02}"
    words = dict(line.split(" ", 1) for line in stem.with_suffix(".txt").read_text(encoding="utf-8").splitlines())
    grid = np.fromfile(f"{stem}.grid.f64", dtype="<f8").reshape(-1, 7).T.copy()
    in_time = np.fromfile(f"{stem}.time.f64", dtype="<f8").reshape(-1, 2)
    limits = {key: float(words[key]) for key in words if key.startswith(("c_", "x_"))}
    return Task(
        words["name"], words["input"], limits, *grid[:5],
        turn_s=float(words["turn_s"]), least_s=float(words["least_s"]), speed=grid[5], acceleration=grid[6],
        sample_s=float(words["sample_s"]), in_time=in_time,
    )
