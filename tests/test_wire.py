"""Claims about frames and values: what an honest end sends arrives whole, and nothing else gets past the decoder."""

import json
import os
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from autograder.worker import wire
from autograder.worker.wire import NotData, ProtocolError, decode, encode, name_only

INTEGERS = st.integers(-(2**wire.MAX_BITS) + 1, 2**wire.MAX_BITS - 1)
SCALARS = (
    st.none()
    | st.booleans()
    | INTEGERS
    | st.floats()
    | st.complex_numbers()
    | st.text(st.characters(exclude_categories=["Cs"]))
)
DTYPES = st.sampled_from(sorted(wire.DTYPES)).map(np.dtype)
ARRAYS = npst.arrays(DTYPES, npst.array_shapes(min_dims=0, min_side=0))
DATA = st.recursive(
    SCALARS | ARRAYS | ARRAYS.map(lambda a: a.reshape(-1)[0] if a.size else None),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(st.text("ab") | INTEGERS, inner, max_size=4)
    ),
    max_leaves=12,
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.sampled_from(sorted(wire.DTYPES)),
    lambda inner: (
        st.lists(inner, max_size=5)
        | st.dictionaries(st.text(), inner, max_size=3)
        | st.builds(
            lambda kind, rest: [kind, *rest],
            st.sampled_from(["list", "tuple", "dict", "array", "scalar", "complex", "other", "function"]),
            st.lists(inner, max_size=4),
        )
    ),
    max_leaves=20,
)


def same(a, b):
    """Equal in type, shape and every bit that counts; nan is nan."""
    if type(a) is not type(b):
        return False
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return same(list(a.items()), list(b.items()))
    if isinstance(a, np.ndarray | np.generic):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    return repr(a) == repr(b)


def through_json(value, otherwise=wire.refuse):
    code, body = encode(value, otherwise)
    return json.loads(json.dumps(code)), body


@given(DATA)
def test_data_arrives_as_it_was_sent(value):
    assert same(decode(*through_json(value)), value)


@given(npst.arrays(DTYPES.map(lambda d: d.newbyteorder(">")), (2, 3)))
def test_big_endian_and_transposed_arrays_arrive_with_their_values(array):
    np.testing.assert_array_equal(decode(*through_json(array.T)), array.T)


def test_an_array_that_arrived_can_be_written_to():
    decode(*through_json(np.zeros(3)))[0] = 1


@given(JSON, st.binary(max_size=64))
def test_whatever_json_comes_gives_data_or_a_protocol_error(code, body):
    try:
        encode(decode(code, body), name_only)
    except ProtocolError:
        pass


@given(st.binary(max_size=200), st.booleans())
def test_whatever_bytes_come_give_a_frame_or_an_error_of_the_protocol(junk, framed):
    head = wire.PREFIX.pack(wire.MAGIC, len(junk) // 2, len(junk) - len(junk) // 2) if framed else b""
    read, write = os.pipe()
    os.write(write, head + junk)
    os.close(write)
    with open(read, "rb") as pipe:
        try:
            wire.receive(wire.Source(pipe.fileno()))
        except (ProtocolError, EOFError):
            pass


@pytest.mark.parametrize(
    ("code", "body"),
    [
        (["array", "<f8", 1 << 40], b""),
        (["array", "<f8", -1], b""),
        (["array", "|O", 1], bytes(8)),
        (["array", "<f8", 1], bytes(9)),
        (["list", *[["array", "<f8", 2]] * 2], bytes(16)),
        (["array", "<f8", *[1] * 40], bytes(8)),
        (["dict", *[[k, None] for k in range(wire.MAX_KEYS + 1)]], b""),
        (["dict", [["list"], None]], b""),
        (["list"] * (wire.MAX_VALUES + 1), b""),
        (["function", 0], b""),
        (["complex", "1", "x"], b""),
        (1 << wire.MAX_BITS, b""),
        ({}, b""),
        ([], b""),
    ],
    ids=str,
)
def test_a_value_that_no_honest_end_sends_is_refused(code, body):
    with pytest.raises(ProtocolError):
        decode(code, body)


def test_a_value_nested_too_deeply_is_refused():
    code = None
    for _ in range(wire.MAX_DEPTH + 1):
        code = ["list", code]
    with pytest.raises(ProtocolError, match="deep"):
        decode(code, b"")


@pytest.mark.parametrize("header", [b"[" * 100_000, b"1" * 10_000, b"[]", b"\xff", b'{"a":'], ids=lambda h: str(h[:8]))
def test_a_header_that_is_no_object_is_refused(header):
    read, write = os.pipe()
    sender = threading.Thread(
        target=lambda: (os.write(write, wire.PREFIX.pack(wire.MAGIC, len(header), 0) + header), os.close(write))
    )
    sender.start()
    with open(read, "rb") as pipe, pytest.raises(ProtocolError):
        wire.receive(wire.Source(pipe.fileno()))
    sender.join()


def test_a_boolean_array_holds_nothing_but_booleans():
    assert decode(["array", "|b1", 3], b"\0\1\xff").tobytes() == b"\0\1\1"


def test_a_lone_surrogate_does_not_get_as_far_as_a_report():
    assert decode("\ud800", b"").encode("utf-8") == b"?"


@pytest.mark.parametrize(
    ("value", "name"),
    [
        (object(), "object"),
        (np.array([1, None]), "array of object"),
        (range(3), "range"),
        (1 << wire.MAX_BITS, "int"),
        (type("Liar", (float,), {"__eq__": lambda *_: True})(1), "test_wire.Liar"),
    ],
)
def test_what_is_no_data_crosses_as_the_name_of_its_type(value, name):
    found = decode(*through_json([value], name_only))[0]
    assert found == NotData(name)
    with pytest.raises(TypeError, match="a number, a text or an array was expected"):
        encode(value)


@pytest.mark.parametrize(
    "value",
    [np.zeros(wire.MAX_BODY // 8 + 1), [0] * (wire.MAX_VALUES + 1), dict.fromkeys(range(wire.MAX_KEYS + 1))],
    ids=lambda value: type(value).__name__,
)
def test_a_value_larger_than_a_frame_is_not_sent(value):
    with pytest.raises(ValueError, match="more than"):
        encode(value)
