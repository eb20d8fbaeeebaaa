"""The wire format: what goes through it unchanged, and what it refuses."""

from __future__ import annotations

import io
import json
import math
import struct
import zipfile
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp
from grasp_bench.predictors import wire
from grasp_bench.predictors.protocol import checked
from grasp_bench.scenario.seeding import Purpose, stream

K = Intrinsics(12, 9, 10.0, 11.0, 6.1, 4.4)
RNG = np.random.default_rng(0)
IMAGE = RgbdImage(
    RNG.integers(0, 255, (9, 12, 3), dtype=np.uint8), RNG.uniform(0.4, 0.6, (9, 12)).astype(np.float32), K
)
SEED = wire.seed_of(np.random.default_rng(5))
SOUND: dict[str, Any] = {"rgb": IMAGE.rgb, "depth": IMAGE.depth, "K": K.matrix, "seed": SEED}


def packed(**changed: Any) -> bytes:
    """A request with some arrays changed, or left out where None."""
    body = io.BytesIO()
    np.savez(body, **{k: v for k, v in (SOUND | changed).items() if v is not None})
    return body.getvalue()


def archive(**members: bytes) -> bytes:
    """A request of raw members; the sound ones where none is given."""
    body = io.BytesIO()
    with (
        np.load(io.BytesIO(packed())),
        zipfile.ZipFile(io.BytesIO(packed())) as sound,
        zipfile.ZipFile(body, "w", zipfile.ZIP_DEFLATED) as file,
    ):
        for name in SOUND:
            file.writestr(f"{name}.npy", members.pop(name, sound.read(f"{name}.npy")))
        for name, raw in members.items():
            file.writestr(name, raw)
    return body.getvalue()


def npy(descr: str, shape: str, data: bytes = b"") -> bytes:
    """An .npy file whose header says whatever it is told to."""
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data


# ---------------------------------------------------------------- round trips


@given(
    st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32), st.floats(0.1, 1e5), st.floats(-1e4, 1e4)
)
def test_an_image_survives_the_wire_to_the_bit(
    width: int, height: int, seed: int, f: float, c: float
) -> None:
    rng = np.random.default_rng(seed)
    image = RgbdImage(
        rng.integers(0, 256, (height, width, 3), dtype=np.uint8),
        rng.uniform(0, 9, (height, width)).astype(np.float32),
        Intrinsics(width, height, f, f * 1.1, c, -c),
    )
    back, words = wire.decode_request(wire.encode_request(image, wire.seed_of(rng)))
    np.testing.assert_array_equal(back.rgb, image.rgb)
    np.testing.assert_array_equal(back.depth, image.depth)
    assert back.intrinsics == image.intrinsics
    np.testing.assert_array_equal(words, wire.seed_of(rng))
    back.depth[:] = 0  # the predictor may write into it


@given(st.integers(0, 2**31), st.text(max_size=8), st.integers(0, 99))
def test_a_trials_stream_survives_the_wire(seed: int, name: str, attempt: int) -> None:
    here = stream(seed, name, attempt, Purpose.PREDICTOR)
    there = wire.generator(wire.seed_of(stream(seed, name, attempt, Purpose.PREDICTOR)))
    np.testing.assert_array_equal(here.random(5), there.random(5))
    np.testing.assert_array_equal(here.integers(7, size=9), there.integers(7, size=9))


def test_only_numpys_own_streams_travel() -> None:
    with pytest.raises(PredictorError, match="MT19937"):
        wire.seed_of(np.random.Generator(np.random.MT19937(0)))


finite = st.floats(allow_nan=False, allow_infinity=False)


@given(st.lists(st.builds(Grasp, finite, finite, finite, finite, finite), max_size=20))
def test_grasps_survive_the_wire_to_the_bit(grasps: list[Grasp]) -> None:
    assert wire.decode_answer(wire.encode_answer(grasps)) == grasps


def test_quality_may_be_left_out_and_a_request_may_be_compressed() -> None:
    answer = b'{"grasps": [{"x": 1, "y": 2, "angle": 0, "width": 3}]}'
    assert wire.decode_answer(answer) == [Grasp(1, 2, 0, 3, 1.0)]
    body = io.BytesIO()
    np.savez_compressed(body, **SOUND)
    np.testing.assert_array_equal(wire.decode_request(body.getvalue())[0].rgb, IMAGE.rgb)


def test_column_major_arrays_are_read_as_such() -> None:
    image, _ = wire.decode_request(packed(depth=np.asfortranarray(IMAGE.depth)))
    np.testing.assert_array_equal(image.depth, IMAGE.depth)


# ---------------------------------------------------------------- hostile requests


class Trap:
    """Would write a file if anyone unpickled it."""

    def __reduce__(self) -> tuple[Any, ...]:
        import os

        return os.system, ("touch /tmp/grasp-bench-was-here",)


def bomb() -> bytes:
    return archive(depth=npy("'<f4'", "(20000, 20000)", bytes(4 * 10**7)))


def crowded() -> bytes:
    """A sound zip whose end claims a directory of a million entries."""
    body = bytearray(packed())
    body[-10:-6] = struct.pack("<I", 50_000_000)
    return bytes(body)


HOSTILE: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "not a sound .npz"),
    "not a zip": (b"hello, grasps" * 10, "not a sound .npz"),
    "a bare npy": (npy("'<f4'", "(9, 12)", IMAGE.depth.tobytes()), "not a sound .npz"),
    "truncated at the end": (packed()[:-30], "not a sound .npz"),
    "truncated in the middle": (packed()[:200] + packed()[-22:], "not a sound .npz"),
    "flipped bits": (packed()[:180] + bytes(b ^ 0x55 for b in packed()[180:260]) + packed()[260:], "npz"),
    "a huge directory": (crowded(), "must hold exactly"),
    "a zip64 end": (packed()[:-22] + b"PK\x06\x07" + bytes(16) + packed()[-22:], "not a sound .npz"),
    "an array too few": (packed(seed=None), "must hold exactly rgb, depth, K, seed"),
    "an array too many": (packed(mask=IMAGE.depth), "must hold exactly"),
    "a path out of the archive": (archive(**{"../../evil.npy": b""}), "must hold exactly"),
    "a pickled object": (packed(rgb=np.array([Trap()], dtype=object)), "must hold uint8, got object"),
    "a pickled object under another type": (
        archive(depth=npy("'|O'", "(9, 12)", b"cos\nsystem\n(S'true'\ntR.")),
        "float32, got object",
    ),
    "a zip bomb": (bomb(), "take more than"),
    "a shape of terabytes": (archive(depth=npy("'<f4'", "(1000000, 1000000)")), "not what it holds"),
    "a negative shape": (
        archive(depth=npy("'<f4'", "(-9, -12)", IMAGE.depth.tobytes())),
        "npz|not what it holds",
    ),
    "a shape of a million axes": (archive(depth=npy("'<f4'", "(1," * 4000 + ")", b"1234")), "npz|not what"),
    "a header that is code": (archive(depth=npy("__import__('os').getpid()", "(9, 12)")), "npz"),
    "a header that nests": (archive(depth=npy("(" * 3000 + ")" * 3000, "(9, 12)")), "npz"),
    "a format from the future": (archive(depth=b"\x93NUMPY\x09\x00\x02\x00{}"), "version"),
    "data longer than the shape": (
        archive(depth=npy("'<f4'", "(9, 12)", IMAGE.depth.tobytes() + b"....")),
        "not what it holds",
    ),
    "double precision": (packed(depth=IMAGE.depth.astype(float)), "must hold float32, got float64"),
    "the other byte order": (packed(depth=IMAGE.depth.astype(">f4")), "must hold float32, got >f4"),
    "colours as floats": (packed(rgb=IMAGE.rgb / 255), "must hold uint8"),
    "grey": (packed(rgb=IMAGE.rgb[..., 0]), r"rgb must be \(9, 12, 3\)"),
    "with alpha": (packed(rgb=np.zeros((9, 12, 4), np.uint8)), "rgb must be"),
    "sizes that differ": (packed(depth=IMAGE.depth[:5]), "rgb must be"),
    "no pixels": (
        packed(depth=np.zeros((0, 0), np.float32), rgb=np.zeros((0, 0, 3), np.uint8)),
        "depth must have",
    ),
    "depth in a row": (packed(depth=IMAGE.depth.ravel()), "depth must have"),
    "NaN depth": (packed(depth=np.full((9, 12), np.nan, np.float32)), "finite"),
    "negative depth": (packed(depth=-IMAGE.depth), "not negative"),
    "infinite focal length": (packed(K=np.diag([np.inf, 1.0, 1.0])), "focal lengths"),
    "NaN focal length": (packed(K=np.full((3, 3), np.nan)), "focal lengths"),
    "K with skew": (packed(K=K.matrix + [[0, 3, 0], [0, 0, 0], [0, 0, 0]]), "K must be"),
    "K as a vector": (packed(K=np.array([1.0, 1.0, 6.0, 4.0])), "K must have"),
    "one seed": (packed(seed=np.uint64(7)), "seed"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_request_is_refused_with_a_reason(name: str) -> None:
    body, reason = HOSTILE[name]
    with pytest.raises(wire.RequestError, match=reason):
        wire.decode_request(body, limit=10**6)


@given(st.binary(max_size=400))
def test_any_bytes_are_an_image_or_refused(noise: bytes) -> None:
    with pytest.raises(wire.RequestError):
        wire.decode_request(noise)


@given(st.data())
def test_any_damage_to_a_request_is_refused_or_harmless(data: st.DataObject) -> None:
    body = bytearray(packed())
    for _ in range(data.draw(st.integers(1, 5))):
        body[data.draw(st.integers(0, len(body) - 1))] = data.draw(st.integers(0, 255))
    try:
        image, seed = wire.decode_request(bytes(body))
    except wire.RequestError:
        return
    assert image.depth.shape == image.rgb.shape[:2]
    assert seed.shape == (4,)


# ---------------------------------------------------------------- hostile answers


def answer(**fields: Any) -> bytes:
    return json.dumps({"grasps": [{"x": 3, "y": 3, "angle": 0, "width": 5, "quality": 1} | fields]}).encode()


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (b"", "not JSON"),
        (b"<html>It works!</html>", "not JSON"),
        (b"\xff\xfe\x00{", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b'{"grasps": [', "not JSON"),
        (b'{"x": ' + b"9" * 5000 + b"}", "not JSON"),
        (b"[]", "must be a JSON object, got list"),
        (b"null", "must be a JSON object, got NoneType"),
        (b"{}", r"got the keys \(none\)"),
        (b'{"grasps": null}', "got the keys 'grasps'"),
        (b'{"grasps": [], "more": 1}', "got the keys 'grasps', 'more'"),
        (b'{"grasps": [[1, 2, 3, 4, 5]]}', r"grasp 0 of the answer must have x, y.*got \[1, 2"),
        (b'{"grasps": [{"x": 1, "y": 1, "angle": 0}]}', "must have x, y, angle, width"),
        (answer(qualty=0.5), "must have x, y, angle, width"),
        (answer(x="3"), "x must be a number, got '3'"),
        (answer(width=None), "width must be a number, got None"),
        (answer(angle=True), "angle must be a number, got True"),
        (answer(y=[3]), "y must be a number"),
        (answer(x=math.nan), "NaN is not a number"),
        (answer(x=-math.inf), "-Infinity is not a number"),
    ],
)
def test_an_answer_that_holds_no_grasps_is_refused_with_a_reason(body: bytes, reason: str) -> None:
    with pytest.raises(PredictorError, match=reason):
        wire.decode_answer(body)


def test_a_number_too_large_for_a_float_does_not_pass() -> None:
    for body in (b'{"grasps": [{"x": 1e999, "y": 1, "angle": 0, "width": 3}]}', answer(x=10**400)):
        with pytest.raises(PredictorError, match=r"NaN or infinity|not a number"):
            checked(wire.decode_answer(body), K)


keys = st.sampled_from(["grasps", "x", "y", "angle", "width", "quality", "z"])
json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner),
    max_leaves=20,
)


@given(json_values)
def test_any_json_is_sound_grasps_or_refused(content: Any) -> None:
    try:
        grasps = checked(wire.decode_answer(json.dumps(content).encode()), K)
    except PredictorError:
        return
    assert all(0 <= g.x <= K.width and 0 <= g.y <= K.height and g.width > 0 for g in grasps)
