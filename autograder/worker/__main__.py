"""A worker by itself, for computers that cannot fork one: `python -m worker LEVEL`, from the folder above."""

import os
import sys

from . import harden
from .serve import Server, forget_ourselves, private_descriptors
from .shell import notebook

GIB = 1 << 30

requests, replies = private_descriptors()
sys.path.remove(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ready = notebook()
if sys.argv[1] == "limits":
    harden.limit(harden.mapped_bytes() + GIB)
forget_ourselves()
Server(requests, replies, ready).serve()
