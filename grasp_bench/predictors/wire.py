"""The wire format between the harness and a predictor in another process.

``POST /predict`` has an ``.npz`` body with exactly four arrays:

========= ============== ==============================================================
``rgb``   (H, W, 3) u1   colours
``depth`` (H, W) f4      z-depth in metres, 0 where the camera measured nothing
``K``     (3, 3) f8      pinhole intrinsics in pixels; the image's edge is at 0
``seed``  (4,) u8        what is random in this trial; see :func:`generator`
========= ============== ==============================================================

The answer is JSON, ``{"grasps": [{"x": …, "y": …, "angle": …, "width": …, "quality": …}, …]}``, best
first, in the units of :class:`grasp_bench.Grasp`; or ``{"error": "…"}`` with a status other than 200.
From protocol 2 on a grasp may be ``{"position": [x, y, z], "rotation": [[…], […], […]], "opening": …,
"quality": …}`` instead, in the units of :class:`grasp_bench.GraspPose` and the camera's frame.
``GET /info`` answers ``{"protocol": 2, …}`` with whatever else identifies the predictor; servers of protocol
1 are asked as ever.

What arrives is never unpickled, and nothing is allocated on the word of a header.
"""

from __future__ import annotations

import io
import json
import math
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import GraspBenchError, PredictorError
from grasp_bench.grasps import Grasp, GraspPose, SpatialGrasp

PROTOCOL = 2
"""What this side speaks; :data:`UNDERSTOOD` are those of servers that it can ask."""
UNDERSTOOD = (1, 2)
REQUEST_BYTES = 128 * 2**20
"""Largest request: an image of 4096 × 4096 pixels, the largest a scenario may have, fits."""
ANSWER_BYTES = 2**20
"""Largest answer: a thousand grasps take a tenth of that."""
INFO_BYTES = 2**16
"""Largest answer to ``GET /info``."""

_ARRAYS = {"rgb": np.dtype(np.uint8), "depth": np.dtype("<f4"), "K": np.dtype("<f8"), "seed": np.dtype("<u8")}
_FIELDS = ("x", "y", "angle", "width", "quality")
_POSE = ("position", "rotation", "opening", "quality")

Seed = NDArray[np.uint64]


class RequestError(GraspBenchError):
    """A request that holds no image; answered with status 400."""


# ---------------------------------------------------------------- what is random


def seed_of(rng: np.random.Generator) -> Seed:
    """Return the (4,) state of a trial's fresh random stream.

    Raises:
        PredictorError: for a generator other than NumPy's default, PCG64.
    """
    state: Any = rng.bit_generator.state
    if state["bit_generator"] != "PCG64":
        raise PredictorError(f"a remote predictor needs a PCG64 stream, got {state['bit_generator']}")
    words = [state["state"][key] >> shift & (2**64 - 1) for key in ("state", "inc") for shift in (64, 0)]
    return np.array(words, np.uint64)


def generator(seed: Seed) -> np.random.Generator:
    """Return the trial's random stream, exactly as a predictor in the harness's own process gets it."""
    high, low, inc_high, inc_low = (int(word) for word in seed)
    bits = np.random.PCG64(0)
    bits.state = {
        "bit_generator": "PCG64",
        "has_uint32": 0,
        "uinteger": 0,
        "state": {"state": high << 64 | low, "inc": inc_high << 64 | inc_low},
    }
    return np.random.Generator(bits)


# ---------------------------------------------------------------- requests


def encode_request(image: RgbdImage, seed: Seed) -> bytes:
    """Return the body of ``POST /predict``."""
    body = io.BytesIO()
    np.savez(body, rgb=image.rgb, depth=image.depth, K=image.intrinsics.matrix, seed=seed)
    return body.getvalue()


def decode_request(body: bytes, limit: int = REQUEST_BYTES) -> tuple[RgbdImage, Seed]:
    """Read image and seed of a request.

    Args:
        body: content of an ``.npz`` file.
        limit: most bytes its members may hold when unpacked.

    Raises:
        RequestError: saying what is wrong with it.
    """
    arrays = _unpack(body, limit)
    rgb, depth, matrix, seed = (arrays[name] for name in _ARRAYS)
    if depth.ndim != 2 or depth.size == 0:
        raise RequestError(f"depth must have the shape (H, W), got {depth.shape}")
    if matrix.shape != (3, 3) or seed.shape != (4,):
        raise RequestError(f"K must have the shape (3, 3) and seed (4,), got {matrix.shape} and {seed.shape}")
    height, width = depth.shape
    try:
        intrinsics = Intrinsics(width, height, *(float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2))))
        if not np.array_equal(intrinsics.matrix, matrix):
            raise ValueError("K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        return RgbdImage(rgb, depth, intrinsics), seed
    except ValueError as error:
        raise RequestError(str(error)) from error


def _unpack(body: bytes, limit: int) -> dict[str, NDArray[Any]]:
    """Read the arrays of an npz file of known names and types, writeable."""
    _check_directory(body)
    try:
        with zipfile.ZipFile(io.BytesIO(body)) as archive:
            members = archive.infolist()
            if sorted(m.filename for m in members) != sorted(f"{name}.npy" for name in _ARRAYS):
                raise RequestError(f"the .npz must hold exactly {', '.join(_ARRAYS)}")
            if sum(m.file_size for m in members) > limit:
                raise RequestError(f"the arrays take more than {limit} bytes")
            # zipfile reads no more of a member than its header declares.
            return {m.filename.removesuffix(".npy"): _array(archive.read(m), m.filename) for m in members}
    except RequestError:
        raise
    except Exception as error:  # zipfile and NumPy's header parser raise a dozen types at hostile input
        raise RequestError(f"the body is not a sound .npz file ({type(error).__name__}: {error})") from error


def _check_directory(body: bytes) -> None:
    # zipfile makes an object of every entry before anyone can count them, so a directory of millions
    # must be refused first. The 22 bytes at the end say how long it is.
    end, locator64 = body[-22:], body[-42:-38]
    if end[:4] != b"PK\x05\x06" or locator64 == b"PK\x06\x07" or end[20:] != b"\0\0":
        raise RequestError("the body is not a sound .npz file, as numpy.savez writes it: its end is missing")
    if int.from_bytes(end[12:16], "little") > 4096:
        raise RequestError(f"the .npz must hold exactly {', '.join(_ARRAYS)}")


def _array(raw: bytes, member: str) -> NDArray[Any]:
    # numpy.load would allocate what the header claims before it looks whether the bytes are there.
    stream = io.BytesIO(raw)
    version = np.lib.format.read_magic(stream)
    if version not in ((1, 0), (2, 0)):
        raise RequestError(f"{member} has the unknown format version {version}")
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = read(stream)
    wanted = _ARRAYS[member.removesuffix(".npy")]
    if dtype != wanted:
        raise RequestError(f"{member} must hold {wanted}, got {dtype}")
    if (
        len(shape) > 3
        or min(shape, default=1) < 0
        or (math.prod(shape) * wanted.itemsize != len(raw) - stream.tell())
    ):
        raise RequestError(f"{member} claims the shape {shape}, which is not what it holds")
    flat = np.frombuffer(raw, wanted, offset=stream.tell())
    return flat.reshape(shape, order="F" if fortran else "C").copy()


# ---------------------------------------------------------------- answers


def encode_answer(grasps: list[Grasp]) -> bytes:
    """Return the body of a good answer; numbers survive it to the bit."""
    rows = [_row(g) for g in grasps]
    return json.dumps({"grasps": rows}, allow_nan=False).encode()


def _row(grasp: Grasp) -> dict[str, Any]:
    if isinstance(grasp, SpatialGrasp):
        pose = grasp.pose
        lists = {"position": pose.position.tolist(), "rotation": pose.rotation.tolist()}
        return lists | {"opening": float(pose.opening), "quality": float(pose.quality)}
    return {name: float(getattr(grasp, name)) for name in _FIELDS}


def decode_answer(body: bytes) -> list[Grasp | GraspPose]:
    """Read the grasps of an answer; whether they are in the image, and poses are sound, is not checked.

    Raises:
        PredictorError: saying what is wrong with it.
    """
    content = decode_object(body)
    if set(content) != {"grasps"} or not isinstance(content["grasps"], list):
        raise PredictorError(
            'the answer must be {"grasps": […]}, got the keys '
            f"{', '.join(map(repr, list(content)[:8])) or '(none)'}"
        )
    return [_grasp(i, row) for i, row in enumerate(content["grasps"])]


def _grasp(i: int, row: Any) -> Grasp | GraspPose:
    if isinstance(row, dict) and not set(row) & set(_FIELDS[:4]) and set(row) & set(_POSE[:3]):
        return _pose(i, row)
    if not isinstance(row, dict) or not set(_FIELDS[:4]) <= set(row) <= set(_FIELDS):
        raise PredictorError(
            f"grasp {i} of the answer must have x, y, angle, width and quality, got {repr(row)[:100]}"
        )
    for name, value in row.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise PredictorError(f"grasp {i} of the answer: {name} must be a number, got {repr(value)[:100]}")
    return Grasp(**row)


def _pose(i: int, row: dict[str, Any]) -> GraspPose:
    if not set(_POSE[:3]) <= set(row) <= set(_POSE):
        raise PredictorError(
            f"grasp {i} of the answer must have {', '.join(_POSE[:3])} and quality, got {repr(row)[:100]}"
        )
    numbers: dict[str, Any] = {}
    for name, value in row.items():
        shape: tuple[int, ...] = {"position": (3,), "rotation": (3, 3)}.get(name, ())
        flat: Any = value if shape else [value]
        if shape == (3, 3) and isinstance(value, list) and all(isinstance(r, list) for r in value):
            flat = [v for r in value for v in r]
        right = isinstance(flat, list) and len(flat) == math.prod(shape)
        if not right or any(isinstance(v, bool) or not isinstance(v, (int, float)) for v in flat):
            what = {(): "a number", (3,): "a list of 3 numbers"}.get(shape, "3 lists of 3 numbers")
            raise PredictorError(f"grasp {i} of the answer: {name} must be {what}, got {repr(value)[:100]}")
        try:
            numbers[name] = np.array([float(v) for v in flat]).reshape(shape)
        except OverflowError as error:
            raise PredictorError(
                f"grasp {i} of the answer: {name} holds a number beyond reckoning"
            ) from error
    return GraspPose(**numbers)


def decode_object(body: bytes) -> dict[str, Any]:
    """Read a JSON object without NaN.

    Raises:
        PredictorError: for anything else.
    """

    def refuse(token: str) -> None:
        raise ValueError(f"{token} is not a number")

    try:
        content = json.loads(body, parse_constant=refuse)
    except (ValueError, RecursionError) as error:  # includes what is not UTF-8
        raise PredictorError(f"the answer is not JSON ({str(error)[:100]})") from error
    if not isinstance(content, dict):
        raise PredictorError(f"the answer must be a JSON object, got {type(content).__name__}")
    return content
