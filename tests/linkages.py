"""Random linkages that can do what a test asks of them."""

from collections.abc import Iterator

import numpy as np

from mechlib.wiper import MassProperties, Wiper

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
