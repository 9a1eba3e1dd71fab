#!/usr/bin/env python3
# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Writes the shipped tables from closed formulas, with no code of camwright: lifts of the default job (ramp, flank and nose), and points.

Ramp: the lift velocity rises from 0 to v over 8 deg as a quintic smoothstep, then stays for 12 deg.
Flank and nose: s = L + c2 x^2 + c4 x^4 + c6 x^6 + c8 x^8 with x the angle from the nose; the four coefficients meet the
ramp in lift, velocity, acceleration (0) and jerk (0), so that the lift has a continuous third derivative everywhere.
"""
import math
import pathlib

RISE, STEADY = math.radians(8.0), math.radians(12.0)


def solve(rows, right):
    """Gaussian elimination with pivoting, small and exact enough for 4 unknowns."""
    n = len(rows)
    a = [list(row) + [value] for row, value in zip(rows, right)]
    for i in range(n):
        p = max(range(i, n), key=lambda k: abs(a[k][i]))
        a[i], a[p] = a[p], a[i]
        for k in range(i + 1, n):
            f = a[k][i] / a[i][i]
            a[k] = [x - f * y for x, y in zip(a[k], a[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (a[i][n] - sum(a[i][k] * x[k] for k in range(i + 1, n))) / a[i][i]
    return x


def lobe(lift_mm, half_angle_deg, ramp_mm):
    """Lift over the angle from the nose (rad), both sides alike."""
    half = math.radians(half_angle_deg)
    velocity = ramp_mm / (RISE / 2 + STEADY)
    b = half
    powers = (2, 4, 6, 8)
    rows = [
        [b**p for p in powers],
        [p * b ** (p - 1) for p in powers],
        [p * (p - 1) * b ** (p - 2) for p in powers],
        [p * (p - 1) * (p - 2) * b ** (p - 3) for p in powers],
    ]
    c = solve(rows, [ramp_mm - lift_mm, -velocity, 0.0, 0.0])

    def s(x):
        x = abs(x)
        if x <= half:
            return lift_mm + sum(k * x**p for k, p in zip(c, powers))
        t = half + STEADY + RISE - x  # angle since the ramp began
        if t <= 0:
            return 0.0
        if t >= RISE:
            return velocity * (t - RISE / 2)
        u = t / RISE  # integral of the smoothstep 10u^3 - 15u^4 + 6u^5
        return velocity * RISE * (2.5 * u**4 - 3 * u**5 + u**6)

    return s


def write(name, title, lift_mm, half_angle_deg, ramp_mm):
    s = lobe(lift_mm, half_angle_deg, ramp_mm)
    lines = [f"# {title}", "# cam angle 0 is the centre of the base circle, the nose is at 180 deg", "cam_angle_deg,lift_mm"]
    lines += [f"{i / 10:.1f},{s(math.radians(i / 10 - 180)):.3f}" for i in range(3600)]
    path = pathlib.Path(__file__).with_name(name)
    path.write_text("\n".join(lines) + "\n")


write("intake.csv", "Intake lobe: lift 6.2 mm, 58 deg from ramp to nose, ramps 0.2 mm", 6.2, 58.0, 0.2)
write("exhaust.csv", "Exhaust lobe: lift 5.8 mm, 60 deg from ramp to nose, ramps 0.25 mm", 5.8, 60.0, 0.25)


def oblong(name, title, half_way_mm, radius_mm):
    """Points of two half circles and the lines that join them, 5 degrees and about 1 mm apart."""
    points = []
    for side in (1, -1):
        for step in range(-18, 18):
            angle = math.radians(5 * step + 2.5)
            points.append((side * (half_way_mm + radius_mm * math.cos(angle)), side * radius_mm * math.sin(angle)))
        count = round(2 * half_way_mm)
        points += [(side * (half_way_mm - (k + 0.5) * 2 * half_way_mm / count), side * radius_mm) for k in range(count)]
    lines = [f"# {title}", "x_mm,y_mm"] + [f"{x:.3f},{y:.3f}" for x, y in points]
    pathlib.Path(__file__).with_name(name).write_text("\n".join(lines) + "\n")


oblong("oblong_points.csv", "Points of an oblong of 36 by 20 mm", 8.0, 10.0)
