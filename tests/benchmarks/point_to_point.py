# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Judges point-to-point moves against Ruckig: the same duration, every limit kept.

    python3.11 tests/benchmarks/point_to_point.py [--count 20000] [--seed 20261121]

Builds camwright/examples/point_to_point_cases.rs, makes an environment under target/benchmarks once, and prints a table. Ends with 1
if a limit is broken, a target is missed, or a move takes longer than Ruckig's. See README.md.
"""

import argparse
import subprocess
import sys
import time

from environment import WORK, build, enter

COLUMNS = ("distance", "velocity", "max_velocity", "max_acceleration", "max_jerk", "duration", "v", "a", "j", "missed")
# Differences of positions round, the more the shorter the move: to so many units in the last place of the largest position.
ULPS = 32.0
GRID = 4000.0
LONGER = 1e-9


def ruckig_durations(rows):
    """Ruckig's durations (s) of all moves, and the time (s) it took to plan them."""
    from ruckig import InputParameter, Result, Ruckig, Trajectory

    planner, wanted, trajectory = Ruckig(1), InputParameter(1), Trajectory(1)
    durations, took = [], 0.0
    for distance, velocity, most_velocity, most_acceleration, most_jerk in rows[:, :5]:
        wanted.current_velocity, wanted.target_position = [velocity], [distance]
        wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = [most_velocity], [most_acceleration], [most_jerk]
        start = time.perf_counter()
        result = planner.calculate(wanted, trajectory)
        took += time.perf_counter() - start
        durations.append(trajectory.duration if result in (Result.Working, Result.Finished) else float("nan"))
    return durations, took


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--count", type=int, default=20000, help="random moves, every other from rest")
    options.add_argument("--seed", type=int, default=20261121, help="their seed")
    options = options.parse_args()
    enter(__file__)

    import numpy as np

    file = WORK / "moves.f64"
    printed = subprocess.run(
        [build("point_to_point_cases"), str(options.count), str(options.seed), file], check=True, capture_output=True, text=True
    ).stdout
    rows = np.fromfile(file).reshape(-1, len(COLUMNS))
    column = {name: rows[:, index] for index, name in enumerate(COLUMNS)}
    durations, took = ruckig_durations(rows)
    longer = column["duration"] / np.array(durations) - 1.0
    step = column["duration"] / GRID
    rounding = ULPS * np.spacing(np.maximum(np.abs(column["distance"]), np.abs(column["velocity"]) * column["duration"]))
    uses = {
        name: (column[name] - rounding * (2.0 / step) ** order) / column["max_" + name_of]
        for order, (name, name_of) in enumerate((("v", "velocity"), ("a", "acceleration"), ("j", "jerk")), start=1)
    }
    print(f"{options.count} moves to rest, seed {options.seed}, every other from rest, the others from a velocity")
    fine = True
    for kind, chosen in (("from rest", column["velocity"] == 0.0), ("from a velocity", column["velocity"] != 0.0)):
        found = longer[chosen]
        known = found[~np.isnan(found)]
        same, shorter = (np.abs(known) <= LONGER).sum(), (known < -LONGER).sum()
        print(
            f"{kind:16} {chosen.sum():6} moves: {same} as long as Ruckig's, {shorter} shorter, {(known > LONGER).sum()} longer "
            f"(by {max(known.max(), 0.0):.1e} at most), {np.isnan(found).sum()} without an answer of Ruckig's"
        )
        fine &= known.max() <= LONGER
    for name, use in uses.items():
        print(f"largest use of the limit of {name}: {use.max():.7f}")
        fine &= use.max() <= 1.0 + 1e-6
    print(f"farthest from the target at the end: {column['missed'].max():.1e} mm")
    fine &= column["missed"].max() <= 1e-9
    ours = float(printed) / 1e9
    print(f"planning: {1e6 * ours / options.count:.2f} us a move, Ruckig {1e6 * took / options.count:.2f} us (called from Python)")
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
