"""The mechanisms as the book shows them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.path import Path

from mechlib import drawn
from mechlib.cylinder import Cylinder
from mechlib.fourbar import FourBar
from mechlib.motion import Motion
from mechlib.sweep import consecutive
from mechlib.wiper import Wiper

TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)


def figure(machine, draw=drawn.wiper, **more):
    motion = Motion(TURN, TURN, np.ones_like(TURN), np.zeros_like(TURN))
    return draw(machine, consecutive(machine, motion, machine.position(0.0), tol=1e-12), **more)


def rigid(moving):
    """Its joints at every frame, once it is seen that every body keeps its lengths."""
    joints = {name: np.broadcast_to(place, (moving.frames, 2)) for name, place in moving.joints.items()}
    for names in moving.bodies.values():
        for one, other in pairwise(names):
            length = np.linalg.norm(joints[one] - joints[other], axis=1)
            np.testing.assert_allclose(length, length[0], atol=1e-12)
    return joints


def test_the_bodies_of_the_wiper_are_rigid_and_its_blades_stay_on_the_glass():
    """Of any size: the glass follows the blades."""
    for machine in (Wiper(), Wiper(r0=0.49, r1=0.21, r2=0.44, r3=0.30, r4=0.5, r5=0.4, r6=1.0)):
        moving = figure(machine)
        joints = rigid(moving)
        for end in "GH":
            assert Path(moving.backdrop).contains_points(joints[end]).all()


def test_what_is_passed_on_comes_before_what_is_usual():
    assert figure(Wiper()).cyclic
    assert not figure(Wiper(), cyclic=False, alt="another").cyclic


def test_the_rod_slides_in_the_barrel_from_stop_to_stop_and_both_are_in_line():
    """On either side, and for a rocker whose centre of mass is nearer than A."""
    near = (*Cylinder().masses[:2], replace(Cylinder().masses[2], centre=0.1))
    for machine, branch in ((Cylinder(), "right"), (Cylinder(), "left"), (Cylinder(masses=near), "right")):
        a, still = np.linspace(*machine.stroke, 24), np.zeros(24)
        moving = drawn.cylinder(machine, machine.sweep(machine.length(Motion(a, a, still, still)), branch))
        joints = rigid(moving)
        start, piston, pin, mouth = (joints[name] @ (1, 1j) for name in ("O₂", "P", "A", "_mouth"))
        line = (mouth - start) / abs(mouth - start)
        along = [(point - start) / line for point in (piston, pin, mouth)]
        np.testing.assert_allclose(np.imag(along), 0, atol=1e-12)
        for distance, expected in zip(np.real(along), (a, a + 0.4, 0.8 + still), strict=True):
            np.testing.assert_allclose(distance, expected, atol=1e-12)
        np.testing.assert_allclose(abs(joints["A"] @ (1, 1j)), 0.25, atol=1e-12)
        np.testing.assert_allclose(moving.input.values, a, atol=1e-12)


def test_the_coupler_of_the_four_bar_is_a_rigid_triangle_wherever_its_frame_lies():
    for linkage in (FourBar(), FourBar(x0=0.3, y0=-0.2, theta0=0.7)):
        moving = figure(linkage, drawn.fourbar)
        joints = rigid(moving)
        assert moving.bodies["coupler"] == "ABPA"
        np.testing.assert_allclose(joints["P"], linkage.coupler_point(TURN), atol=1e-14)
        np.testing.assert_allclose(joints["O₂"][0], [linkage.x0, linkage.y0])
        assert np.linalg.norm(joints["O₄"] - joints["O₂"], axis=1) == pytest.approx(linkage.r1)


def test_a_cloud_of_throws_lies_about_its_mean_and_is_enlarged():
    means = np.array([[0.1, 0.2], [0.3, 0.4]])
    aside = 1e-5 * np.array([[[1, 2], [3, 4]], [[-1, -2], [-3, -4]]])
    cloud = figure(FourBar(), drawn.fourbar, throws=means + aside, enlarged=1000).cloud
    np.testing.assert_allclose(cloud, [[0.11, 0.22], [0.33, 0.44], [0.09, 0.18], [0.27, 0.36]])
