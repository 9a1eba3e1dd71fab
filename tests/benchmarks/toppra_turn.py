# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""TOPP-RA on a task: no jerk, not periodic, on 3600 intervals; set up as fast as it can be."""

import logging
import time

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint
from toppra.interpolator import AbstractGeometricPath

from turn_task import TURN_RAD

logging.getLogger("toppra").setLevel(logging.ERROR)
INTERVALS = 3600
SOLVER = "seidel"


class KnownPath(AbstractGeometricPath):
    """C and X over C, read from a table at the grid points: evaluating the path costs TOPP-RA nothing."""

    def __init__(self, x, x1, x2):
        one, none = np.ones_like(x), np.zeros_like(x)
        angle = np.linspace(0.0, TURN_RAD, len(x))
        self.orders = [np.column_stack(pair) for pair in ((angle, x), (one, x1), (none, x2))]

    def __call__(self, path_positions, order=0):
        if len(path_positions) != len(self.orders[order]):
            raise ValueError("only known at the grid points")
        return self.orders[order]

    @property
    def dof(self):
        return 2

    @property
    def path_interval(self):
        return np.array([0.0, TURN_RAD])


class KnownSpeedBound(toppra.constraint.LinearConstraint):
    """A bound on the path's speed, from a table at the grid points: JointVelocityConstraintVarying calls Python at each."""

    def __init__(self, largest_z):
        super().__init__()
        self.dof = 2
        self.largest_z = largest_z

    def compute_constraint_params(self, path, gridpoints, *args, **kwargs):
        bounds = np.column_stack([np.zeros_like(self.largest_z), self.largest_z])
        return None, None, None, None, None, None, bounds


class ToppraTurn:
    """A task as TOPP-RA takes it, with our speed at the seam."""

    def __init__(self, task):
        step = task.count // INTERVALS
        assert step * INTERVALS == task.count
        closed = lambda values: np.append(values[::step], values[0])
        self.grid = np.linspace(0.0, TURN_RAD, INTERVALS + 1)
        self.path_values = tuple(closed(values) for values in (task.x, task.x1, task.x2))
        self.largest_z = 1.0 / closed(task.per_bound)
        self.bound = np.minimum(closed(task.bound), task.limits["c_velocity"])
        self.x_velocity = task.limits["x_velocity"]
        self.accelerations = np.array([task.limits["c_acceleration"], task.limits["x_acceleration"]])
        self.seam = min(float(task.speed[0]), (1.0 - 1e-9) * float(np.sqrt(self.largest_z[0])))

    def plan(self, scheme=toppra.constraint.DiscretizationType.Interpolation, stock=False):
        """Time to plan and time of the turn (s); `stock`: with the varying velocity constraint that comes with it."""
        start = time.perf_counter()
        path = KnownPath(*self.path_values)
        if stock:
            step = self.grid[1]
            table = np.zeros((len(self.grid), 2, 2))
            table[:, 0, 1], table[:, 1, 1] = self.bound, self.x_velocity
            table[:, :, 0] = -table[:, :, 1]
            velocity = toppra.constraint.JointVelocityConstraintVarying(lambda s: table[int(s / step + 0.5)])
        else:
            velocity = KnownSpeedBound(self.largest_z)
        acceleration = toppra.constraint.JointAccelerationConstraint(self.accelerations, scheme)
        algorithm = toppra.algorithm.TOPPRA([velocity, acceleration], path, gridpoints=self.grid, solver_wrapper=SOLVER)
        _, speed, _ = algorithm.compute_parameterization(self.seam, self.seam)
        took = time.perf_counter() - start
        if speed is None or np.isnan(speed).any():
            return took, float("nan")
        return took, float(np.sum(2.0 * np.diff(self.grid) / (speed[1:] + speed[:-1])))
