# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Judges the fastest turn: against the best that an independent oracle finds, a proven lower bound, and TOPP-RA.

    python3.11 tests/benchmarks/turn_speed.py [--random 20] [--seed 20261121] [--starts 2] [--runs 15] [--jobs 2] [--no-oracle]

Builds camwright/examples/turn_cases.rs, makes an environment under target/benchmarks once, and prints tables. Ends with 1 if a
limit is broken or a turn is more than 1 % slower than the best found. See README.md.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time

from environment import WORK, build, enter

FARTHEST = 0.01
# As it is printed with four digits, 1.0000.
LARGEST_RATIO = 1.00005


def judge(work):
    """Bound, limits and oracle of one task, in a process of its own."""
    import lower_bound
    import oracle
    import turn_task

    index, directory, random_starts, seed, with_oracle = work
    task = turn_task.load(directory, index)
    bound_s, envelope = lower_bound.lower_bound(task)
    begin = time.perf_counter()
    times, ended = oracle.best_turn(task, envelope, random_starts, seed) if with_oracle else ({}, {})
    return {
        "index": index, "task": (task.name, task.input, task.turn_s, task.least_s), "bound_s": bound_s,
        "by_angle": turn_task.ratios_by_angle(task), "in_time": turn_task.ratios_in_time(task),
        "starts": times, "ended": ended, "took_s": time.perf_counter() - begin,
    }


def side_by_side(example, tasks, runs):
    """Planning times (s) of both, run by turns; and TOPP-RA's turn."""
    from toppra.constraint import DiscretizationType
    from toppra_turn import ToppraTurn

    def ours(index, count):
        example.stdin.write(f"{index} {count}\n")
        example.stdin.flush()
        return [int(word) * 1e-9 for word in example.stdout.readline().split()]

    rows = []
    for index, task in enumerate(tasks):
        turn = ToppraTurn(task)
        kinds = {
            "interpolation": lambda: turn.plan(),
            "collocation": lambda: turn.plan(DiscretizationType.Collocation),
            "stock": lambda: turn.plan(stock=True),
        }
        ours(index, 2)
        turns = {kind: plan()[1] for kind, plan in kinds.items()}
        took = {kind: [] for kind in ("ours", *kinds)}
        for _ in range(runs):
            # The second of two: the first finds its caches full of the other's.
            took["ours"].append(ours(index, 2)[1])
            for kind, plan in kinds.items():
                took[kind].append(plan()[0])
        rows.append((task, turns, took))
    return rows


def print_side_by_side(rows):
    from statistics import median

    print("\nPlanning time (ms, best and median) and turn (s); TOPP-RA with seidel on 3600 intervals: interpolation (its default)")
    print("and collocation with the speed bound from a table, stock with JointVelocityConstraintVarying")
    print(f"{'case':24} {'ours':>13} {'interpolation':>15} {'collocation':>15} {'stock':>15} {'faster':>7} {'turn':>8} {'TOPP-RA':>8} {'ratio':>7}")
    ratios = []
    for task, turns, took in rows:
        cell = lambda kind: f"{1e3 * min(took[kind]):6.1f} {1e3 * median(took[kind]):6.1f}"
        fastest = min(("interpolation", "collocation", "stock"), key=lambda kind: median(took[kind]))
        faster = median(took[fastest]) / median(took["ours"])
        ratios.append(faster)
        toppra = turns["interpolation"]
        print(
            f"{task.name:24} {cell('ours'):>13} {cell('interpolation'):>15} {cell('collocation'):>15} {cell('stock'):>15} "
            f"{faster:7.2f} {task.turn_s:8.4f} {toppra:8.4f} {task.turn_s / toppra:7.4f}"
        )
    print(f"faster: median of TOPP-RA's fastest set-up over ours; over all cases {min(ratios):.2f} to {max(ratios):.2f}, median {median(ratios):.2f}")


def quantiles(values):
    import numpy as np

    marks = np.quantile(values, (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)) * 100.0
    return "least {:.2f} %, quartiles {:.2f} {:.2f} {:.2f} %, nine tenths below {:.2f} %, worst {:.2f} %".format(*marks)


def print_judged(judged, with_oracle):
    """The tables of gaps, worst last; and whether all is well."""
    from turn_task import LIMITS

    fine = True
    for row in judged:
        name, _, turn_s, _ = row["task"]
        # What refining the judged turn itself finds counts: it is a plan that keeps every limit.
        row["best_s"] = min([*row["starts"].values(), *row["ended"].values()], default=float("nan"))
        row["gap"], row["above"] = turn_s / row["best_s"] - 1.0, turn_s / row["bound_s"] - 1.0
        elsewhere = [value for name, value in row["ended"].items() if name != "judged"] + [row["best_s"]]
        row["nearby"] = row["ended"].get("judged", float("nan"))
        row["elsewhere"] = row["nearby"] / min(elsewhere) - 1.0
        row["worst"] = max(row["by_angle"].max(), row["in_time"].max())
    judged.sort(key=lambda row: row["gap"] if with_oracle else row["above"])

    print("\nTurn (s) against the best found and against the proven lower bound (no jerk); worst last")
    print("nearby: what programs make of the judged turn; elsewhere: by how much the best of other starts is faster than that")
    print(f"{'case':24} {'turn':>8} {'best':>8} {'gap %':>6} {'nearby':>8} {'elsewh. %':>9} {'bound':>8} {'above %':>8} {'own bound':>9} {'by angle':>9} {'in time':>8}  largest use")
    for row in judged:
        name, _, turn_s, least_s = row["task"]
        which = LIMITS[int(row["by_angle"].argmax())]
        print(
            f"{name:24} {turn_s:8.4f} {row['best_s']:8.4f} {100 * row['gap']:6.2f} {row['nearby']:8.4f} {100 * row['elsewhere']:9.2f} "
            f"{row['bound_s']:8.4f} {100 * row['above']:8.2f} {least_s:9.4f} {row['by_angle'].max():9.5f} {row['in_time'].max():8.5f}  {which}"
        )
    if with_oracle:
        print(f"gap to the best found:    {quantiles([row['gap'] for row in judged])}")
    print(f"above the lower bound:    {quantiles([row['above'] for row in judged])}")

    for row in judged:
        name, lobe, turn_s, least_s = row["task"]
        if row["worst"] > LARGEST_RATIO:
            fine = False
            print(f"LIMIT BROKEN: {name}: {row['worst']:.6f} ({lobe})")
        if with_oracle and row["gap"] > FARTHEST:
            fine = False
            print(f"SLOW: {name}: {100 * row['gap']:.2f} % above the best found ({lobe})")
        if row["bound_s"] > min(turn_s, row["best_s"] if with_oracle else turn_s) or least_s > turn_s:
            fine = False
            print(f"BOUND BROKEN: {name}: bound {row['bound_s']:.6f}, own {least_s:.6f}, turn {turn_s:.6f}, best {row['best_s']:.6f} s")
    if with_oracle:
        print("\nWhere the starts ended on the coarse knots (s)")
        for row in judged:
            print(f"{row['task'][0]:24} " + ", ".join(f"{name} {value:.4f}" for name, value in row["starts"].items()))
    return fine


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--random", type=int, default=20, help="random lobes beside the four reference cases")
    options.add_argument("--seed", type=int, default=20261121, help="seed of the first random lobe, and of the oracle's starts")
    options.add_argument("--starts", type=int, default=2, help="random starts of the oracle beside the envelope and a constant")
    options.add_argument("--runs", type=int, default=15, help="timed runs of each planner")
    options.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), help="tasks that the oracle works on at a time")
    options.add_argument("--no-oracle", action="store_true", help="only limits, lower bound and TOPP-RA")
    options = options.parse_args()

    enter(__file__)

    import multiprocessing

    import turn_task

    example_path = build("turn_cases")
    directory = WORK / "cases"
    shutil.rmtree(directory, ignore_errors=True)
    print(f"4 reference cases, {options.random} random lobes of seeds from {options.seed}", flush=True)
    load = os.getloadavg()[0]
    print(f"{os.cpu_count()} cores, load {load:.1f} before anything was started", flush=True)
    with subprocess.Popen(
        [example_path, directory, str(options.random), str(options.seed)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as example:
        count = int(example.stdout.readline())
        tasks = [turn_task.load(directory, index) for index in range(count)]
        for task in tasks:
            print(f"  {task.name}: {task.input}")
        print_side_by_side(side_by_side(example, tasks, options.runs))
        del tasks
        example.stdin.close()
    sys.stdout.flush()

    work = [(index, directory, options.starts, options.seed, not options.no_oracle) for index in range(count)]
    judged = []
    try:
        with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
            for row in pool.imap_unordered(judge, work):
                judged.append(row)
                found = ", ".join(f"{name} {value:.4f}" for name, value in row["ended"].items())
                line = f"{row['task'][0]}, {row['took_s']:.0f} s: turn {row['task'][2]:.4f}, bound {row['bound_s']:.4f}, {found}"
                print(f"  judged {len(judged)} of {count}: {line}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print(f"interrupted: {len(judged)} of {count} judged", flush=True)
    whole = len(judged) == count
    judged.sort(key=lambda row: row["index"])
    if not judged:
        return 1
    return 0 if print_judged(judged, not options.no_oracle) and whole else 1


if __name__ == "__main__":
    sys.exit(main())
