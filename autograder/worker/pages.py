"""The pages of memory that a worker writes, whatever it computes: copied before anybody waits for them.

A fork shares every page until somebody writes it; then the kernel stops the writer and copies that page, and for a
short notebook that is half of its time.  A rehearsal finds these pages once, for all workers.
"""

import ctypes
import os
from array import array
from collections.abc import Callable, Iterable

PAGE = os.sysconf("SC_PAGE_SIZE")
MADV_POPULATE_WRITE = 23  # since Linux 5.14; before, every page waits for its first write
EXCLUSIVE = 1 << 56  # in an entry of the page map: no other process shares the page


def written_by(rehearse: Callable[[], object]) -> array:
    """Addresses of the pages that a fork writes while it rehearses; none where the kernel does not tell."""
    reading, writing = os.pipe()
    if os.fork() == 0:
        try:
            null = os.open(os.devnull, os.O_RDWR)
            for standard in range(3):
                os.dup2(null, standard)
            before = list(_private())
            rehearse()
            with open(writing, "wb") as file:
                array("Q", _exclusive(before)).tofile(file)
        finally:
            os._exit(0)
    os.close(writing)
    with open(reading, "rb") as file:
        return array("Q", file.read())


def copy(addresses: Iterable[int]) -> None:
    """Have these pages to oneself, unchanged."""
    madvise = ctypes.CDLL(None).madvise
    madvise.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    for address in addresses:
        madvise(address, PAGE, MADV_POPULATE_WRITE)


def _private() -> Iterable[range]:
    """The pages that a fork can write and gets a copy of."""
    with open("/proc/self/maps") as file:
        for line in file:
            addresses, permissions, *_ = line.split()
            if permissions == "rw-p":
                start, stop = (int(address, 16) for address in addresses.split("-"))
                yield range(start, stop, PAGE)


def _exclusive(mappings: Iterable[range]) -> Iterable[int]:
    with open("/proc/self/pagemap", "rb") as file:
        for pages in mappings:
            file.seek(pages.start // PAGE * 8)
            entries = array("Q", file.read(len(pages) * 8))
            yield from (page for page, entry in zip(pages, entries, strict=False) if entry & EXCLUSIVE)
