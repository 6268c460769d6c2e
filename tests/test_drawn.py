"""The mechanisms as the book shows them."""

from itertools import pairwise

import numpy as np
from matplotlib.path import Path

from mechlib import drawn
from mechlib.motion import Motion
from mechlib.sweep import consecutive
from mechlib.wiper import Wiper


def figure(machine, **more):
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    motion = Motion(turn, turn, np.ones_like(turn), np.zeros_like(turn))
    sweep = consecutive(machine, motion, machine.position(0.0), tol=1e-12)
    return drawn.wiper(machine, sweep, **more)


def test_the_bodies_of_the_wiper_are_rigid_and_its_blades_stay_on_the_glass():
    """Of any size: the glass follows the blades."""
    for machine in (Wiper(), Wiper(r0=0.49, r1=0.21, r2=0.44, r3=0.30, r4=0.5, r5=0.4, r6=1.0)):
        moving = figure(machine)
        joints = {name: np.broadcast_to(place, (24, 2)) for name, place in moving.joints.items()}
        for names in moving.bodies.values():
            for one, other in pairwise(names):
                length = np.linalg.norm(joints[one] - joints[other], axis=1)
                np.testing.assert_allclose(length, length[0], atol=1e-12)
        for end in "GH":
            assert Path(moving.backdrop).contains_points(joints[end]).all()


def test_what_is_passed_on_comes_before_what_is_usual():
    assert figure(Wiper()).cyclic
    assert not figure(Wiper(), cyclic=False, alt="another").cyclic
