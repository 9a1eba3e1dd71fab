# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""A time that no plan of a task goes below: the linear program without jerk, with the acceleration of X.

What it asks is necessary, whatever happens between its points, so its time is a bound and not an estimate:
    z_k                     <= bound at the point,
    |z_(k+1) - z_k|         <= 2 a_C d                 because |dz/dC| = 2 |C acceleration|,
    |x1^2 z|_k^(k+1)        <= 2 a_X integral |x1| dC  because d(x1^2 z)/dC = 2 x1 (X acceleration), and x1^2 z = (dX/dt)^2,
and on the whole grid z rises and falls by 2 a_C per angle at most; between its points it is below that, and below the bound. Every row has one coefficient above 0 and one below, so there is a
plan that is the largest at all points at once; the program finds it, and no plan is faster anywhere.
"""

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_array, vstack

from turn_task import TURN_RAD

# A second for HiGHS. Where C limits, the whole grid follows; only what X limits is left this coarse.
POINTS = 14_400


def lower_bound(task):
    """The bound (s), and the z on the task's grid that it is made of."""
    step = max(1, task.count // POINTS)
    at = slice(None, None, step)
    per_bound, x, x1 = task.per_bound[at], task.x[at], task.x1[at]
    n = len(x)
    d = TURN_RAD / n
    after = (np.arange(n) + 1) % n
    # Variables are shares of the bound, so that HiGHS's tolerance of 1e-7 is a share too.
    top = 1.0 / per_bound

    def rows(weight, room):
        """|weight_(k+1) z_(k+1) - weight_k z_k| <= room_k, each row scaled by its room."""
        index = np.arange(n)
        values = np.concatenate([-weight * top / room, weight[after] * top[after] / room])
        matrix = csr_array((values, (np.tile(index, 2), np.concatenate([index, after]))), shape=(n, n))
        return vstack([matrix, -matrix])

    rise = 2.0 * task.limits["c_acceleration"] * d
    # The exact integral where x1 keeps its sign; where it does not, no less than it.
    fine = np.abs(task.x1).reshape(n, step)
    largest = np.maximum(fine.max(axis=1), fine.max(axis=1)[after]) * d
    one_sign = (fine.min(axis=1) > 0.0) & (x1 * x1[after] > 0.0)
    way = np.where(one_sign, np.abs(x[after] - x), largest)
    kinetic = 2.0 * task.limits["x_acceleration"] * np.maximum(way, 1e-9)
    matrix = vstack([rows(np.ones(n), np.full(n, rise)), rows(x1**2, kinetic)], format="csr")
    done = linprog(-np.ones(n), A_ub=matrix, b_ub=np.ones(4 * n), bounds=(0.0, 1.0), method="highs")
    if done.status != 0:
        raise RuntimeError(f"{task.name}: the program of the lower bound: {done.message}")
    return on_grid(task, slice(None, None, step), done.x * top * (1.0 + 1e-6))


def on_grid(task, at, largest):
    """The bound (s) and z on the whole grid, below the bound everywhere and below what the program found at its points."""
    n, d = task.count, task.spacing
    rise = 2.0 * task.limits["c_acceleration"] * d
    allowed = 1.0 / task.per_bound
    z = allowed.copy()
    z[at] = np.minimum(z[at], largest)
    # Up from the left and from the right by the rise at most, three turns of it so that the seam does not matter.
    ramp = rise * np.arange(3 * n)
    for _ in range(2):
        z = (np.minimum.accumulate(np.tile(z, 3) - ramp) + ramp)[n : 2 * n]
        z = z[::-1]
    after = np.roll(z, -1)
    peak = 0.5 * (z + after + rise)
    root = np.sqrt(peak)
    tents = 2.0 * d / rise * ((peak - z) / (np.sqrt(z) + root) + (peak - after) / (root + np.sqrt(after)))
    # Between two points the bound is above its chord by an eighth of its second difference; twice that is taken.
    bend = np.abs(np.roll(allowed, -1) - 2.0 * allowed + np.roll(allowed, 1))
    above = 0.25 * np.maximum(bend, np.roll(bend, -1))
    chords = 2.0 * d / (np.sqrt(allowed + above) + np.sqrt(np.roll(allowed, -1) + above))
    return float(np.sum(np.maximum(tents, chords))), z
