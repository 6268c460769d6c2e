"""The sweep of all points at once: the numbers of the sweep point after point, at any size, in little memory."""

import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from mechlib import batched as module
from mechlib import cramer
from mechlib.batched import batched
from mechlib.hacksaw import Hacksaw
from mechlib.motion import Motion, MotorProfile
from mechlib.newton import ConvergenceError
from mechlib.sweep import consecutive

SEED = [-0.1, -0.5, 3.0]


def run_up(points):
    profile = MotorProfile.through()
    return profile.at(np.linspace(0, 2 * profile.T, points))


def nine(sweep):
    return np.hstack((sweep.position, sweep.velocity, sweep.acceleration))


@pytest.mark.parametrize("points", [1, 2, 3, 90, 97, 98, 1000, module.BLOCK, module.BLOCK + 1, 3 * module.BLOCK])
def test_all_points_at_once_give_the_numbers_of_the_closed_form(points):
    saw, motion = Hacksaw(), run_up(points)
    found = batched(saw, motion, SEED, tol=1e-9)
    exact = np.hstack(saw.closed_form(motion.position, motion.velocity, motion.acceleration))
    assert np.abs(nine(found) - exact).max() < 1e-12  # the accelerations reach 26
    assert found.errors.max() < 1e-9


def test_all_points_at_once_give_the_numbers_of_one_after_the_other_to_1e_12():
    saw, motion = Hacksaw(), run_up(1000)
    assert np.abs(nine(batched(saw, motion, SEED, 1e-9)) - nine(consecutive(saw, motion, SEED, 1e-9))).max() < 1e-12


@given(st.floats(0.02, 0.1), st.floats(0.0, 1.0), st.floats(0.1, 3.0), st.floats(-500, 500), st.floats(-6, 6))
def test_any_saw_over_any_many_turns_is_found_on_the_branch_and_the_turn_of_its_seed(r2, offset, longer, sweep, begin):
    """Some turn many times between two points of the first coarse sweep: it notices, and takes a finer one."""
    saw = Hacksaw(r1y=r2 * (0.1 + offset), r2=r2, r3=r2 * (1.25 + offset + longer))
    t = np.linspace(0, 1, 4000)
    motion = Motion(t, begin + sweep * t**2, 2 * sweep * t, np.full_like(t, 2 * sweep))
    found = batched(saw, motion, saw.position(begin), tol=1e-9)
    built = saw.position(motion.position)
    built[:, 1] = np.unwrap(built[:, 1])
    np.testing.assert_allclose(found.position, built, rtol=0, atol=1e-8)


def test_the_coarse_sweep_is_made_finer_where_it_strays(monkeypatch):
    lengths = []
    follow = module.follow
    monkeypatch.setattr(module, "follow", lambda *a: lengths.append(len(a[3])) or follow(*a))
    t = np.linspace(0, 1, 20_000)
    motion = Motion(t, 900 * t, np.full_like(t, 900.0), np.zeros_like(t))
    saw = Hacksaw(r3=0.125)
    found = batched(saw, motion, SEED, tol=1e-9)
    assert lengths[0] == module.COARSE < lengths[-1] < len(t)
    assert (saw.branch(found.position) == "left").all()


def test_a_leap_to_another_turn_is_noticed_at_the_seam_of_two_blocks():
    blocks = list(module._blocks(3 * module.BLOCK))
    assert blocks[0].start == 0
    assert blocks[-1].stop == 3 * module.BLOCK
    assert all(a.stop == b.start + 1 for a, b in pairwise(blocks))


def test_a_position_that_no_sweep_finds_is_told_with_its_point():
    with pytest.raises(ConvergenceError, match=r"^point 0, t = 0 s: no root after 2 iterations"):
        batched(Hacksaw(), run_up(1000), SEED, max_iterations=2)


def test_the_memory_beside_the_result_does_not_grow_with_the_points():
    """But for a number a point: which points these are."""
    saw, beside = Hacksaw(), []
    batched(saw, run_up(1000), SEED)  # what is derived once is there
    for points in (100_000, 400_000):
        motion = run_up(points)
        tracemalloc.start()
        found = batched(saw, motion, SEED)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        kept = sum(
            a.nbytes for a in (found.position, found.velocity, found.acceleration, found.iterations, found.errors)
        )
        beside.append((peak - kept) / 2**20)
    assert max(beside) < 40  # MB
    assert beside[1] - beside[0] < 8  # for 300 000 points


@given(st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_cramers_rule_solves_as_elimination_does(n, seed):
    rng = np.random.default_rng(seed)
    matrices, vectors = rng.normal(size=(5, n, n)), rng.normal(size=(5, n))
    determinant, adjugate = cramer.adjugate(np.moveaxis(matrices, 0, -1))
    solution = (np.array(cramer.times(adjugate, vectors.T)) / determinant).T
    condition = np.linalg.cond(matrices)
    off = np.linalg.norm(solution - np.linalg.solve(matrices, vectors[..., None])[..., 0], axis=1)
    assert (off <= 50 * np.finfo(float).eps * condition**2 * np.linalg.norm(solution, axis=1)).all()
    np.testing.assert_allclose(
        determinant, np.linalg.det(matrices), rtol=0, atol=1e-13 * (1 + np.abs(matrices).max()) ** n
    )


@pytest.mark.parametrize("n", [1, 2, 3])
def test_cramers_rule_in_symbols_is_the_inverse(n):
    matrix = sp.MatrixSymbol("m", n, n).as_explicit()
    determinant, adjugate = cramer.adjugate(matrix.tolist())
    assert sp.expand(determinant - matrix.det()) == 0
    assert sp.expand(sp.Matrix(adjugate) - matrix.adjugate()) == sp.zeros(n)


def test_cramers_rule_is_refused_for_more_than_three_unknowns():
    with pytest.raises(ValueError, match="got 4"):
        cramer.adjugate(np.eye(4))
