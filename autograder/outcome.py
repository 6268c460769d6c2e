"""What comes of calling a function: a value, an exception, or nothing in time. Data only."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Value:
    """What a call returned: data, already decoded; never an object of the student's."""

    value: Any


@dataclass(frozen=True)
class Raised:
    """The exception that a call ended in: names and words only."""

    type: str
    bases: tuple[str, ...]
    message: str

    @classmethod
    def of(cls, mistake: BaseException) -> "Raised":
        bases = tuple(base.__name__ for base in type(mistake).__mro__[1:-1])
        return cls(type(mistake).__name__, bases, str(mistake))

    def is_a(self, name: str) -> bool:
        return name == self.type or name in self.bases


@dataclass(frozen=True)
class Lost:
    """No answer: the time ran out, or the process died."""

    why: str
    timeout: bool = False


Outcome = Value | Raised | Lost
