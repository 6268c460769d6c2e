"""A student's solution, and what is edited in it to make a known mistake."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Edits = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Student:
    """A right solution, and the edits that make each known mistake of it."""

    right: str
    mistakes: dict[str, Edits]

    def written(self, *names: str) -> str | None:
        """The solution with these mistakes; None where they meet."""
        text = self.right
        for name in names:
            for old, new in self.mistakes[name]:
                if text.count(old) != 1:
                    return None
                text = text.replace(old, new)
        return text


def function(text: str, name: str) -> Callable:
    space = {"np": np, "math": math}
    exec(text, space)
    return space[name]
