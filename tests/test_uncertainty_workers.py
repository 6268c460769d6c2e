"""Throws shared out among workers give the bits of one process, and take no more memory the more they are."""

import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context

import numpy as np
import pytest

from mechlib.fourbar import LENGTHS, FourBar
from mechlib.laws import tolerances
from mechlib.uncertainty import TASK, Varied, monte_carlo, quasi_monte_carlo

LINKAGE = FourBar()
THETA2 = np.array([[0.4], [1.2], [6.2]])
POINT = Varied(LINKAGE, LENGTHS, partial(FourBar.coupler_point, theta2=THETA2, open_points="leave out"))
WIDE = tolerances(POINT.nominal, 0.1)  # so that some throws have no result
BLOCK = 64
THROWS = 5 * TASK * BLOCK + 7  # six tasks, the last of them a short one


@contextmanager
def dask():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


WORKERS = {
    "two threads": lambda: ThreadPoolExecutor(2),
    "two processes": lambda: ProcessPoolExecutor(2, get_context("spawn")),
    "two Dask workers": dask,
}


def bits(thrown):
    moments = thrown.moments
    sums = moments.mean, moments.second, moments.third, moments.fourth
    return thrown.open, thrown.first_open, moments.throws, [each.tobytes() for each in sums]


@pytest.mark.parametrize("workers", WORKERS.values(), ids=WORKERS)
def test_any_workers_give_the_bits_of_one_process(workers):
    thrown = partial(monte_carlo, POINT, WIDE, THROWS, open_throws="leave out", block=BLOCK)
    alone = [thrown(seed=seed) for seed in (1, 2)]
    narrow = partial(quasi_monte_carlo, POINT, tolerances(POINT.nominal, 1e-5), 64, sets=4)
    with workers() as executor:
        shared = [thrown(seed=seed, executor=executor) for seed in (1, 2)]
        even = narrow(executor=executor)
    assert 0 < alone[0].open < THROWS / 10
    assert len(alone[0].first_open) == 10
    assert [bits(each) for each in shared] == [bits(each) for each in alone]
    assert bits(alone[0]) != bits(alone[1])
    assert [each.tobytes() for each in (even.means, even.deviations)] == [
        each.tobytes() for each in (narrow().means, narrow().deviations)
    ]


PEAKS = """
from functools import partial
from pathlib import Path
from mechlib.fourbar import LENGTHS, FourBar
from mechlib.laws import tolerances
from mechlib.uncertainty import Varied, monte_carlo

point = Varied(FourBar(), LENGTHS, partial(FourBar.coupler_point, theta2=[[1.2]]))
for throws in (200_000, 2_000_000):
    monte_carlo(point, tolerances(point.nominal, 1e-5), throws)
    print(next(line.split()[1] for line in Path("/proc/self/status").open() if line.startswith("VmHWM")))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the most that a process has held is read from /proc")
def test_ten_times_the_throws_take_no_more_memory():
    ran = subprocess.run([sys.executable, "-c", PEAKS], capture_output=True, text=True, check=True)
    few, many = map(int, ran.stdout.split())  # kB
    assert many - few < 1_000  # where the points alone would be 32 000
