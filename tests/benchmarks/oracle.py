# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""The best turn that successive linear programs find for a task, from many starts: slow, and of no kin to the planner.

z = (dC/dt)^2 is a periodic quadratic spline on knots of its own, dense where C is slow. A program maximises
sum z / z0^1.5, which is minus twice the change of the turn's time, within a trust region about the plan z0 before it; limits
of jerk j / sqrt z are taken by their tangent at z0, which lies below, so a program's plan keeps them. Speed bounds hold at four
points of every interval. What is found is then looked at on the whole grid of the task, some forty points to an interval, with
z scaled by what it exceeds there. HiGHS solves (scipy.optimize.linprog).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_array, diags_array, vstack

from turn_task import TURN_RAD, excess

# Cells of the task's grid to an interval: a multiple of it, so that points at quarters of an interval lie on the grid.
CELLS = 4
# Intervals of the starts, each cut in three for the best of them: 2880 in the end.
COARSE = 960
FINER = 3
QUARTERS = (0.0, 0.25, 0.5, 0.75, 1.0)
# X limits used less than this by the plan before are left out of a program until one breaks them.
IN_SIGHT = 0.4


class Spline:
    """Periodic quadratic splines on knots at points of a task's grid."""

    def __init__(self, knots, count):
        self.knots, self.count = knots, count
        self.cells = np.diff(np.append(knots, knots[0] + count))
        self.length = self.cells * (TURN_RAD / count)
        self.n = len(knots)

    def rows(self, interval, u):
        """Matrices of z, z' and z'' at shares u of intervals."""
        n, d = self.n, self.length
        before, after = (interval - 1) % n, (interval + 1) % n
        d0, d1, d2 = d[before], d[interval], d[after]
        # Values at both knots of the interval are means of neighbouring coefficients.
        left, right = d1 / (d0 + d1), d2 / (d1 + d2)
        v = 1.0 - u
        # Bernstein polynomials v^2, 2uv, u^2 of (left value, coefficient, right value), and their derivatives.
        index = np.concatenate([before, interval, after])
        line = np.tile(np.arange(len(interval)), 3)

        def matrix(p, q, r):
            values = np.concatenate([p * left, p * (1.0 - left) + q + r * right, r * (1.0 - right)])
            return csr_array((values, (line, index)), shape=(len(interval), n))

        return (
            matrix(v * v, 2.0 * u * v, u * u),
            matrix(-2.0 * v / d1, 2.0 * (v - u) / d1, 2.0 * u / d1),
            matrix(2.0 / d1**2, -4.0 / d1**2, 2.0 / d1**2),
        )

    def on_grid(self):
        """Matrices at every point of the grid, and which points they are."""
        interval = np.repeat(np.arange(self.n), self.cells)
        first = np.repeat(np.concatenate([[0], np.cumsum(self.cells)[:-1]]), self.cells)
        cell = np.arange(self.count) - first
        return self.rows(interval, cell / self.cells[interval]), (self.knots[interval] + cell) % self.count

    def through(self, z_on_grid):
        """Coefficients of a curve given on the grid: exact if it is a quadratic on every interval."""
        ends = np.append(self.knots, self.knots[0] + self.count)
        value = lambda at: z_on_grid[at % self.count]
        return 2.0 * value(ends[:-1] + self.cells // 2) - 0.5 * (value(ends[:-1]) + value(ends[1:]))


def knots_for(z_on_grid, intervals):
    """Knots with three quarters of their density by time and a quarter by angle."""
    count = len(z_on_grid)
    unit = CELLS * FINER
    density = 1.0 / np.sqrt(z_on_grid)
    density = 0.75 * density / density.sum() + 0.25 / count
    places = np.interp(np.arange(intervals) / intervals, np.append(0.0, np.cumsum(density)), np.arange(count + 1))
    return np.unique(np.round(places / unit).astype(int) % (count // unit)) * unit


def finer(knots, count):
    """Every interval cut in FINER."""
    cells = np.diff(np.append(knots, knots[0] + count)) // FINER
    return (knots[:, None] + cells[:, None] * np.arange(FINER)).ravel()


@dataclass
class Plan:
    """A turn that keeps every limit on the whole grid."""

    coefficients: np.ndarray
    z: np.ndarray
    turn_s: float


class Programs:
    """The successive programs of a task on given knots."""

    def __init__(self, task, knots):
        self.task, self.spline = task, Spline(knots, task.count)
        spline = self.spline
        (self.fine, self.fine1, self.fine2), self.at = spline.on_grid()
        self.every = np.arange(spline.n)
        self.points = {}
        for u in QUARTERS:
            cells = np.round(u * spline.cells).astype(int)
            self.points[u] = (*spline.rows(self.every, np.full(spline.n, u)), (knots + cells) % task.count)
        # Rows of X limits that every program has from now on.
        self.seen = {}
        # X jerk between the points of an interval over that at them: more than 1 where X‴ jumps. Learnt from plans.
        self.between = np.ones(spline.n)
        self.interval = np.repeat(self.every, spline.cells)
        # Time of the turn that is judged: what is near it is worth beginning at.
        self.fair_s = task.turn_s
        self.weight = spline.length[np.repeat(self.every, spline.cells)] / spline.cells[np.repeat(self.every, spline.cells)]

    def kept(self, coefficients):
        """The plan of coefficients, slowed down until it keeps every limit on the whole grid; None if z is not above 0."""
        z = self.fine @ coefficients
        if np.min(z) <= 0.0:
            return None
        first, second = self.fine1 @ coefficients, self.fine2 @ coefficients
        self.learn(coefficients, z, first, second)
        factor = 1.0 / excess(self.task.ratios(z, first, second, self.at))
        return Plan(coefficients * factor, z * factor, float(np.sum(self.weight / np.sqrt(z * factor))))

    def learn(self, coefficients, z, first, second):
        """X jerk on the grid and at the points that a program holds it at: the next one is held to the larger of them."""
        task = self.task

        def jerk(z, first, second, at):
            return np.abs(np.sqrt(z) * (task.x3[at] * z + 1.5 * task.x2[at] * first + 0.5 * task.x1[at] * second))

        everywhere, at_points = np.zeros(self.spline.n), np.zeros(self.spline.n)
        np.maximum.at(everywhere, self.interval, jerk(z, first, second, self.at))
        for z_, first_, second_, at in self.points.values():
            values = (np.maximum(z_ @ coefficients, 0.0), first_ @ coefficients, second_ @ coefficients)
            at_points = np.maximum(at_points, jerk(*values, at))
        matters = everywhere > 0.5 * task.limits["x_jerk"]
        self.between = np.where(matters, np.clip(everywhere / np.maximum(at_points, 1e-300), 1.0, 2.0), 1.0)

    def program(self, c0, reach):
        """The best coefficients within a share `reach` of c0 (none: anywhere)."""
        task, limits = self.task, self.task.limits
        blocks, rights, waiting = [], [], {}

        def hold(matrix, right, scale=1.0):
            blocks.append(diags_array(np.broadcast_to(scale, len(right))) @ matrix)
            rights.append(right * scale)

        for u in QUARTERS:
            z_, first, second, at = self.points[u]
            z0 = np.maximum(z_ @ c0, 1e-3)
            x1, x2, x3 = (values[at] for values in (task.x1, task.x2, task.x3))
            if u < 1.0:
                hold(z_, 1.0 / task.per_bound[at], task.per_bound[at])
            if u == 0.0:
                right = np.full(len(z0), 2.0 * limits["c_acceleration"])
                hold(first, right, 1.0 / right)
                hold(-first, right, 1.0 / right)
            # j / sqrt z >= (1.5 - z / (2 z0)) j / sqrt z0, each row divided by j / sqrt z0.
            tangent = diags_array(0.5 / z0) @ z_
            if u in (0.0, 0.5, 1.0):
                row = diags_array(0.5 * np.sqrt(z0) / limits["c_jerk"]) @ second
                hold(tangent + row, np.full(len(z0), 1.5))
                hold(tangent - row, np.full(len(z0), 1.5))
            combine = lambda a, b, c: diags_array(a) @ z_ + diags_array(b) @ first + diags_array(c) @ second
            for kind, row, right, above in (
                ("acceleration", combine(x2, 0.5 * x1, 0.0 * x1) / limits["x_acceleration"], 1.0, None),
                ("jerk", diags_array(self.between * np.sqrt(z0) / limits["x_jerk"]) @ combine(x3, 1.5 * x2, 0.5 * x1), 1.5, tangent),
            ):
                for sign in (1.0, -1.0):
                    key = (kind, u, sign)
                    block = (sign * row if above is None else sign * row + above).tocsr()
                    self.seen[key] = self.seen.get(key, False) | (sign * (row @ c0) > IN_SIGHT)
                    waiting[key] = (block, right)

        scale = np.maximum(c0, 0.05 * (self.points[0.5][0] @ c0))
        z0 = np.maximum(self.fine @ c0, 1e-3)
        gain = (self.fine.T @ (self.weight / z0**1.5)) * scale
        y0 = c0 / scale
        bounds = (0.0, None) if reach is None else np.column_stack([y0 - reach, y0 + reach])
        for _ in range(6):
            x_rows = [block[self.seen[key]] for key, (block, _) in waiting.items()]
            x_rights = [np.full(np.count_nonzero(self.seen[key]), right) for key, (_, right) in waiting.items()]
            matrix = vstack(blocks + x_rows, format="csr") @ diags_array(scale)
            done = linprog(
                -gain / np.mean(gain), A_ub=matrix, b_ub=np.concatenate(rights + x_rights), bounds=bounds, method="highs-ipm"
            )
            if done.x is None:
                return None
            found = done.x * scale
            broken = 0
            for key, (block, right) in waiting.items():
                over = (block @ found > right + 1e-6) & ~self.seen[key]
                self.seen[key] |= over
                broken += np.count_nonzero(over)
            if broken == 0:
                break
        return found

    def improve(self, coefficients, programs, enough, say=lambda line: None):
        """Program after program, until one gains less than a share `enough`."""
        c0 = coefficients
        best = self.kept(c0)
        reach = None
        if best is not None and best.turn_s < 1.2 * self.fair_s:
            # A plan already: from there in steps that its tangents are good for.
            c0, reach = best.coefficients, 0.5
        else:
            best = None
        for index in range(programs):
            found = self.program(c0, reach)
            plan = None if found is None else self.kept(found)
            gain = None if plan is None or best is None else 1.0 - plan.turn_s / best.turn_s
            say(f"    program {index + 1}: reach {reach}, " + ("none" if plan is None else f"{plan.turn_s:.6f} s"))
            if plan is not None and (best is None or gain > -1e-9):
                best, c0 = plan, plan.coefficients
                if gain is not None and gain < enough:
                    break
                reach = 0.5 if reach is None else min(0.5, 1.5 * reach)
            elif best is None:
                # No plan anywhere near so coarse a guess: a slower one.
                c0 = 0.5 * c0
            else:
                reach *= 0.3
                if reach < 5e-3:
                    break
        return best


def starts(task, envelope, random_starts, seed):
    """Guesses of z on the grid: the envelope, a constant, and the envelope times smooth random factors (seeds named)."""
    yield "envelope", envelope
    yield "constant", np.full(task.count, 0.5 * float(np.exp(np.mean(np.log(envelope)))))
    angle = np.arange(task.count) * task.spacing
    for k in range(random_starts):
        random = np.random.default_rng([seed, k])
        wave = sum(
            random.normal(0.0, 0.6 / np.sqrt(order)) * np.cos(order * angle + random.uniform(0.0, TURN_RAD)) for order in range(1, 13)
        )
        yield f"seed {seed}/{k}", envelope * np.exp(wave - np.max(wave))


def smooth(z, cells):
    """z rounded over some cells either way."""
    window = np.hanning(2 * cells + 3)[1:-1]
    window /= window.sum()
    spectrum = np.fft.rfft(np.roll(np.pad(window, (0, len(z) - len(window))), -(len(window) // 2)))
    return np.maximum(np.fft.irfft(np.fft.rfft(z) * spectrum, len(z)), 0.5 * np.min(z))


def best_turn(task, envelope, random_starts, seed, say=lambda line: None):
    """Turn times found from every start (s), by name, and the best plan of all on 2880 intervals: its time and z on the grid."""
    coarse = Programs(task, knots_for(envelope, COARSE))
    found = {}
    for name, z in starts(task, envelope, random_starts, seed):
        say(f"  start {name}")
        plan = coarse.improve(coarse.spline.through(smooth(z, task.count // 720)), 14, 2e-4, say)
        if plan is not None:
            found[name] = plan
    fine = Programs(task, finer(coarse.spline.knots, task.count))

    def refined(z_at_points, at, name):
        z = np.empty(task.count)
        z[at] = z_at_points
        say(f"  {fine.spline.n} intervals from {name}")
        start = fine.kept(fine.spline.through(z))
        plan = None if start is None else fine.improve(start.coefficients, 8, 5e-5, say)
        return plan

    ended = {}
    best = min(found, key=lambda name: found[name].turn_s)
    ended[best] = refined(found[best].z, coarse.at, best)
    # From the turn that is judged: what is to be had near it says whether it ended early or in the wrong place.
    ended["judged"] = refined(task.speed**2, np.arange(task.count), "the turn that is judged")
    times = {name: plan.turn_s for name, plan in found.items()}
    ended = {name: plan for name, plan in ended.items() if plan is not None}
    return times, {name: plan.turn_s for name, plan in ended.items()}
