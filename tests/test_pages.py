"""What a worker writes is copied before anybody waits for it."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux only")

# In a process of its own: this one has threads, and a fork would not have them.
FAULTS = """
import mmap, os, resource, sys
from autograder.worker import pages

data = mmap.mmap(-1, 400 * pages.PAGE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)

def touch():
    for n in range(0, len(data), pages.PAGE):
        data[n] = 1

written = pages.written_by(touch)
for addresses in ([], written):
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        pages.copy(addresses)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        touch()
        print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
        sys.stdout.flush()
        os._exit(0)
    os.waitpid(child, 0)  # this one: the fork of the rehearsal may end later
assert not any(data[:]), "the rehearsal changed the parent"
"""


def test_a_worker_that_copied_what_the_rehearsal_wrote_is_not_stopped_at_each_page_of_it():
    ran = subprocess.run([sys.executable, "-c", FAULTS], stdout=subprocess.PIPE, text=True, check=True)
    without, with_copies = map(int, ran.stdout.split())
    assert without >= 390  # one a page, but for the first and last, which the allocator may have touched
    assert with_copies <= 20
