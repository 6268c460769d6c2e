"""Random linkages that can do what a test asks of them."""

from collections.abc import Iterator

import numpy as np

from mechlib.cylinder import Cylinder
from mechlib.motion import Motion
from mechlib.rigidbody import MassProperties
from mechlib.wiper import Wiper

TURN = np.linspace(0, 2 * np.pi, 361)


def crank_rockers(rng: np.random.Generator) -> Iterator[Wiper]:
    """Wipers with random bars and masses, whose transmission angle stays above 20 degrees."""
    while True:
        r2 = rng.uniform(0.1, 0.5)
        r0, r1, r3 = r2 * rng.uniform([0.8, 0.2, 0.6], [1.3, 0.5, 1.2])
        masses = tuple(MassProperties(*rng.uniform([0.05, 1e-4, 0.05], [1, 0.05, 0.4])) for _ in range(5))
        wiper = Wiper(r0, r1, r2, r3, *rng.uniform(0.2, 0.6, 3), masses)
        if wiper.grashof == "crank-rocker" and (wiper.gap(TURN) < 0).all():
            if np.rad2deg(wiper.transmission_angle(wiper.position(TURN))).min() >= 20:
                yield wiper


def cylinders(rng: np.random.Generator) -> Iterator[tuple[Cylinder, Motion]]:
    """Cylinders with random lengths and masses, and a motion of each that repeats every second and starts from v = 0.

    Cylinder and rocker stay 20 degrees away from a flat triangle.
    """
    t = np.arange(64) / 64
    waves = 2 * np.pi * np.array([[1], [2]])
    while True:
        o2, o4, b = rng.uniform([0.1, 0.3, 0.15], [0.8, 1.2, 0.5])
        li, l, room = rng.uniform([0.1, 0.1, 0.2], [0.5, 0.6, 0.5])
        masses = tuple(MassProperties(*rng.uniform([0.5, 0.01, 0.05], [8, 0.5, 0.8])) for _ in range(3))
        try:
            cylinder = Cylinder(o2, o4, b, l, li, li + room, masses=masses)
        except ValueError:
            continue  # stops and triangle have no stroke in common
        low, high = cylinder.stroke
        swing = rng.uniform(-1, 1, (2, 1))
        swing *= rng.uniform(0.05, 0.45) * (high - low) / np.abs(swing).sum()
        motion = Motion(
            t,
            (low + high) / 2 + l + (swing * np.cos(waves * t)).sum(axis=0),
            -(swing * waves * np.sin(waves * t)).sum(axis=0),
            -(swing * waves**2 * np.cos(waves * t)).sum(axis=0),
        )
        q = cylinder.position(motion.position)
        if np.abs(np.sin(q[:, 0] - q[:, 1])).min() > np.sin(np.deg2rad(20)):
            yield cylinder, motion
