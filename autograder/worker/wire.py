"""Frames and values between judge and worker: data, never code.

A frame is the magic, two lengths, a JSON header, and the bytes of its arrays one after the other.  Plain values are
plain JSON; every other value is a JSON list that begins with its kind.  Arrays are read from the body in the order in
which they appear, so that a frame can never unfold to more than was sent.  The decoder is the judge's wall: whatever
bytes come, it gives data or `ProtocolError`, and calls nothing that the sender made.
"""

import json
import os
import struct
from collections.abc import Callable
from dataclasses import dataclass
from math import prod
from typing import Any, NoReturn

import numpy as np

MAGIC = b"MBC1"
PREFIX = struct.Struct("<4sIQ")
MAX_HEADER = 8 << 20
MAX_BODY = 64 << 20
MAX_DEPTH = 32
MAX_VALUES = 200_000
MAX_KEYS = 1_000  # in all: equal hashes can be forged, and a dict of n such keys costs n squared
MAX_BITS = 64  # a longer int is a trap: 2**x of one would keep the judge busy for ever
MAX_DIMENSIONS = 32
DTYPES = {
    name: np.dtype(name)
    for name in ("|b1", "|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f2", "<f4", "<f8", "<c8", "<c16")
}


to_json = json.JSONEncoder(separators=(",", ":")).encode


class WorkerLost(Exception):
    """The worker is gone, and with it everything it held."""


class ProtocolError(WorkerLost):
    """The other end sent something that no honest end sends."""


@dataclass(frozen=True)
class NotData:
    """Stands where the worker's value was no data; `type` is the name that its class gave itself."""

    type: str


def text(value: Any, limit: int = MAX_HEADER) -> str:
    """A string that can be stored and printed as UTF-8, or ProtocolError."""
    if type(value) is not str:
        raise ProtocolError("text expected")
    return value[:limit].encode("utf-8", "replace").decode()


def type_name(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array of {value.dtype}"[:120]
    kind = type(value)
    return (kind.__qualname__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__qualname__}")[:120]


def refuse(value: Any) -> NoReturn:
    raise TypeError(f"a number, a text or an array was expected, not {type_name(value)}")


def name_only(value: Any) -> list:
    """For `encode`: what is no data crosses as the name of its type."""
    return ["other", type_name(value)]


def encode(value: Any, otherwise: Callable[[Any], list] = refuse) -> tuple[Any, bytes]:
    """A value as JSON and bytes.

    Parameters
    ----------
    value : None, bool, int, float, complex, str, ndarray, numpy scalar, or list, tuple, dict of these
    otherwise : callable
        Gives the JSON for what is no data, or raises.

    Raises
    ------
    ValueError
        If the value is larger than a frame may be.
    """
    arrays, size, values, keys = [], 0, 0, 0

    def array(a):
        nonlocal size
        dtype = a.dtype.newbyteorder("<").str
        if dtype not in DTYPES:
            return None
        size += a.nbytes
        if size > MAX_BODY:
            raise ValueError(f"more than {MAX_BODY >> 20} MiB of numbers")
        arrays.append(a.astype(dtype, copy=False).tobytes())
        return dtype

    def code(x, depth):
        nonlocal values, keys
        values += 1
        if depth > MAX_DEPTH or values > MAX_VALUES:
            raise ValueError(f"nested deeper than {MAX_DEPTH}, or more than {MAX_VALUES} values")
        t = type(x)
        if x is None or t is bool or t is float:
            return x
        if t is int and x.bit_length() <= MAX_BITS:
            return x
        if t is np.float64:  # the most frequent by far: an iterate
            return ["float64", float(x)]
        if t is str:
            return text(x)
        if t is complex:
            return ["complex", x.real, x.imag]
        if t is list:
            return ["list", *(code(y, depth + 1) for y in x)]
        if isinstance(x, tuple):
            return ["tuple", *(code(y, depth + 1) for y in x)]
        if t is dict:
            keys += len(x)
            if keys > MAX_KEYS:
                raise ValueError(f"more than {MAX_KEYS} keys")
            return ["dict", *([code(k, depth + 1), code(v, depth + 1)] for k, v in x.items())]
        if t is np.ndarray and x.ndim <= MAX_DIMENSIONS and (dtype := array(x)):
            return ["array", dtype, *x.shape]
        if isinstance(x, np.generic) and (dtype := array(np.asarray(x))):
            return ["scalar", dtype]
        return otherwise(x)

    return code(value, 0), b"".join(arrays)


def decode(code: Any, body: bytes, function: Callable[[int], Callable] | None = None) -> Any:
    """The value that `encode` coded; arrays are fresh and writable.

    Parameters
    ----------
    code, body
        As `encode` gave them, or anything at all.
    function : callable, optional
        Gives the function that a reference stands for; without it a reference is a ProtocolError.

    Raises
    ------
    ProtocolError
        For whatever `encode` would never have made.
    """
    start, values, keys = 0, 0, 0

    def array(dtype, shape):
        nonlocal start
        kind = DTYPES[dtype]
        if len(shape) > MAX_DIMENSIONS or any(type(n) is not int or n < 0 for n in shape):
            raise ProtocolError("no such shape")
        stop = start + prod(shape) * kind.itemsize
        if stop > len(body):
            raise ProtocolError("array longer than the frame")
        raw, start = body[start:stop], stop
        flat = np.frombuffer(raw, "|u1") != 0 if dtype == "|b1" else np.frombuffer(raw, kind).copy()
        return flat.reshape(shape)

    def value(x, depth):
        nonlocal values, keys
        values += 1
        if depth > MAX_DEPTH or values > MAX_VALUES:
            raise ProtocolError("too deep or too long")
        if type(x) is str:
            return text(x)
        if x is None or type(x) in (bool, float) or (type(x) is int and x.bit_length() <= MAX_BITS):
            return x
        if type(x) is not list or not x:
            raise ProtocolError("a value without a kind")
        kind, *rest = x
        if kind == "float64" and type(rest[0]) is float:
            return np.float64(*rest)
        if kind == "list":
            return [value(y, depth + 1) for y in rest]
        if kind == "tuple":
            return tuple(value(y, depth + 1) for y in rest)
        if kind == "dict":
            keys += len(rest)
            if keys > MAX_KEYS:
                raise ProtocolError("too many keys")
            return {value(k, depth + 1): value(v, depth + 1) for k, v in rest}
        if kind == "array":
            return array(rest[0], rest[1:])
        if kind == "scalar":
            return array(*rest, ())[()]
        if kind == "complex":
            real, imag = rest
            return complex(float(real), float(imag))
        if kind == "other":
            return NotData(text(*rest, 120))
        if kind == "function" and function and type(rest[0]) is int:
            return function(*rest)
        raise ProtocolError("a value of no known kind")

    try:
        found = value(code, 0)
    except (TypeError, ValueError, KeyError, IndexError, OverflowError, RecursionError) as error:
        raise ProtocolError(f"a value that is not one: {type(error).__name__}") from None
    if start != len(body):
        raise ProtocolError("bytes left over")
    return found


def send(fd: int, header: dict, body: bytes = b"", wait: Callable[[], None] = lambda: None) -> None:
    """Write one frame; ValueError if it is larger than the other end would take.

    Parameters
    ----------
    wait : callable, optional
        Called where a pipe that does not block is full; may raise.
    """
    head = to_json(header).encode()
    if len(head) > MAX_HEADER:
        raise ValueError(f"more than {MAX_HEADER >> 20} MiB of text")
    left = memoryview(PREFIX.pack(MAGIC, len(head), len(body)) + head + body)
    while left:
        try:
            left = left[os.write(fd, left) :]
        except BlockingIOError:
            wait()


class Source:
    """A stream to read frames from.

    Parameters
    ----------
    fd : file descriptor
    wait : callable, optional
        Called before a read that may have to wait; may raise.
    """

    def __init__(self, fd: int, wait: Callable[[], None] = lambda: None):
        self.fd, self.wait, self.ahead = fd, wait, bytearray()

    def exactly(self, size: int) -> bytes:
        """So many bytes; EOFError if there are fewer."""
        while len(self.ahead) < size:
            self.wait()
            part = os.read(self.fd, max(1 << 13, min(size - len(self.ahead), 1 << 20)))
            if not part:
                raise EOFError
            self.ahead += part
        found = bytes(self.ahead[:size])
        del self.ahead[:size]
        return found


def receive(source: Source) -> tuple[dict, bytes]:
    """Read one frame; EOFError at the end of the stream, ProtocolError for anything but a frame."""
    magic, head, body = PREFIX.unpack(source.exactly(PREFIX.size))
    if magic != MAGIC or head > MAX_HEADER or body > MAX_BODY:
        raise ProtocolError("stray bytes")
    try:
        header = json.loads(source.exactly(head).decode())
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"a header that is no JSON: {type(error).__name__}") from None
    if type(header) is not dict:
        raise ProtocolError("a header that is no object")
    return header, source.exactly(body)
