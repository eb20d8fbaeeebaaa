"""Networks as predictors, and weights on disk."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import AssetError, PredictorError, UnknownNameError
from grasp_bench.networks.packing import SCALE
from grasp_bench.networks.registry import NETWORKS, build
from grasp_bench.networks.store import WeightsFile
from grasp_bench.networks.weights import load, save
from grasp_bench.predictors import identity
from grasp_bench.predictors.names import load_predictor
from grasp_bench.predictors.network import NetworkPredictor, centre_crop
from grasp_bench.predictors.protocol import PrivilegedPredictor
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.system.integrity import MANIFEST, sha256


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Random weights of two networks, whose quality is nowhere near zero."""
    folder, paths = tmp_path_factory.mktemp("weights"), {}
    for name in ("htc-grasp", "gg-cnn"):
        torch.manual_seed(0)
        network = build(name)
        with torch.no_grad():
            network.get_parameter("head.bias").fill_(0.5)
        paths[name] = folder / f"{name}.safetensors"
        save(network, paths[name], {"network": name, "steps": 0, "note": "θ random"})
    return paths


def image(height: int = 480, width: int = 640, holes: float = 0.05) -> RgbdImage:
    """A table with a box on it, as a noisy sensor sees it."""
    rng = np.random.default_rng(3)
    depth = rng.normal(0.7, 1e-3, (height, width)).astype(np.float32)
    rows, columns = np.s_[height // 2 - 20 : height // 2 + 20], np.s_[width // 2 - 10 : width // 2 + 10]
    depth[rows, columns] = 0.64
    depth[rng.random(depth.shape) < holes] = 0
    rgb = rng.integers(90, 110, (height, width, 3), dtype=np.uint8)
    rgb[rows, columns] = 200
    return RgbdImage(rgb, depth, Intrinsics.from_fov(width, height, 1.1))


# --- predictor ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["htc-grasp", "gg-cnn"])
@pytest.mark.parametrize(
    ("size", "holes"),
    [
        ((480, 640), 0.05),
        ((480, 640), 0.6),
        ((480, 640), 1.0),
        ((150, 700), 0.05),
        ((100, 90), 0.05),
        ((225, 224), 0.0),
    ],
)
def test_grasps_lie_in_the_whole_image(name: str, size: tuple[int, int], holes: float, weights) -> None:
    predictor = NetworkPredictor(name, weights[name], peaks=4)
    grasps = predictor.predict(image(*size, holes=holes))
    assert 1 <= len(grasps) <= 4
    left, top = predictor.crop_origin
    assert (left, top) == ((size[1] - 224) // 2, (size[0] - 224) // 2)
    for grasp in grasps:
        assert max(left, 0) <= grasp.x <= min(left + 224, size[1])
        assert max(top, 0) <= grasp.y <= min(top + 224, size[0])
        assert grasp.width > 0
        assert 0 <= grasp.quality <= 1
    assert [g.quality for g in grasps] == sorted((g.quality for g in grasps), reverse=True)


def test_peaks_of_the_maps_come_back_in_image_pixels(weights) -> None:
    predictor = NetworkPredictor("htc-grasp", weights["htc-grasp"])
    picture = image()
    best = predictor.predict(picture)[0]
    quality = predictor.maps(picture).smoothed().quality
    row, column = np.unravel_index(quality.argmax(), quality.shape)
    assert (best.x, best.y) == (column + 0.5 + 208, row + 0.5 + 128)


def test_predicting_repeats_exactly_and_leaves_threads_alone(weights) -> None:
    predictor, picture = NetworkPredictor("htc-grasp", weights["htc-grasp"]), image()
    threads = torch.get_num_threads()
    assert predictor.predict(picture) == predictor.predict(picture)
    assert torch.get_num_threads() == threads


def test_crop_pads_small_images() -> None:
    picture = image(100, 300)
    rgb, depth, origin = centre_crop(picture, 224)
    assert rgb.shape == (224, 224, 3)
    assert depth.shape == (224, 224)
    assert origin == (38, -62)
    np.testing.assert_array_equal(depth[62:162], picture.depth[:, 38:262])
    assert not depth[:62].any()
    assert not depth[162:].any()
    np.testing.assert_array_equal(rgb[0], picture.rgb[0, 38:262])


def test_importing_the_predictor_does_not_import_torch() -> None:
    code = "import sys, grasp_bench.predictors.network; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_unknown_network() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean htc-grasp"):
        NetworkPredictor("htc-gras")


# --- weights ------------------------------------------------------------------------------


def test_weights_come_back_rounded_to_half_precision(weights) -> None:
    torch.manual_seed(0)
    fresh = build("gg-cnn").state_dict()
    network, metadata = load("gg-cnn", weights["gg-cnn"])
    for key, value in network.state_dict().items():
        assert value.dtype == torch.float32
        if key != "head.bias":
            assert torch.equal(value, fresh[key].half().float())
    assert metadata == {"network": "gg-cnn", "steps": 0, "note": "θ random"}
    assert metadata == WeightsFile(weights["gg-cnn"]).metadata()
    assert weights["gg-cnn"].stat().st_size < 2.2 * 62_420


def test_missing_weights_name_file_and_remedy(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"nowhere\.safetensors are missing.*grasp-bench train"):
        load("htc-grasp", tmp_path / "nowhere.safetensors")


@pytest.mark.parametrize("keep", [0, 5, 100, 60_000])
def test_truncated_weights(keep: int, weights, tmp_path: Path) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    path.write_bytes(weights["gg-cnn"].read_bytes()[:keep])
    with pytest.raises(AssetError, match=r"gg-cnn\.safetensors is truncated"):
        load("gg-cnn", path)


def test_pickles_are_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    torch.save(build("gg-cnn").state_dict(), path)
    with pytest.raises(AssetError, match="not a safetensors file"):
        load("gg-cnn", path)


def test_weights_of_another_network(weights, tmp_path: Path) -> None:
    with pytest.raises(AssetError, match="of network 'gg-cnn', not 'htc-grasp'"):
        load("htc-grasp", weights["gg-cnn"])
    path = tmp_path / "bare.safetensors"
    save_file({"a": torch.zeros(3)}, path)
    with pytest.raises(AssetError, match="does not fit network 'gg-cnn'"):
        load("gg-cnn", path)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda t: {**t, "head.bias": torch.zeros(5).half()}, r"head\.bias has shape \(5,\), not \(4,\)"),
        (lambda t: {k: v for k, v in t.items() if k != "head.bias"}, "1 tensors missing or unknown"),
        (lambda t: {**t, "head.bias": torch.full((4,), float("nan"))}, "not finite"),
    ],
)
def test_wrong_tensors(spoil, message: str, weights, tmp_path: Path) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    save_file(spoil(load_file(weights["gg-cnn"])), path)
    with pytest.raises(AssetError, match=message):
        load("gg-cnn", path)


def test_manifest_is_held_against_the_file(weights, tmp_path: Path) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    path.write_bytes(weights["gg-cnn"].read_bytes())
    WeightsFile(path).enter_in_manifest()
    assert json.loads((tmp_path / MANIFEST).read_text()) == {path.name: sha256(path)}
    load("gg-cnn", path)
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)
    with pytest.raises(AssetError, match="SHA-256"):
        load("gg-cnn", path)
    (tmp_path / MANIFEST).write_text("[")
    with pytest.raises(AssetError, match=r"manifest\.json"):
        load("gg-cnn", path)


def test_diverged_weights_are_not_stored(tmp_path: Path) -> None:
    network = build("gg-cnn")
    with torch.no_grad():
        network.get_parameter("head.bias")[0] = 1e9
    with pytest.raises(ValueError, match="diverged"):
        save(network, tmp_path / "w.safetensors", {})
    assert not list(tmp_path.iterdir())


# --- hostile weights ----------------------------------------------------------------------


def raw(header: bytes | dict, data: bytes = b"", length: int | None = None) -> bytes:
    """A safetensors file that says whatever it is told to."""
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return (len(text) if length is None else length).to_bytes(8, "little") + text + data


def entry(shape: list[int], start: int, end: int, kind: str = "F32") -> dict:
    return {"dtype": kind, "shape": shape, "data_offsets": [start, end]}


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x80\x02cos\nsystem\n(S'true'\ntR.",
        b"PK\x03\x04" + bytes(100),
        raw({}, length=2**63),
        raw({}, length=10**8),
        raw({}, length=3),
        raw(b"{" * 100),
        raw(b"[]"),
        raw(b'{"a": 1}'),
        raw(b"\xff\xfe{}"),
        raw({"head.bias": entry([4], 0, 16)}),
        raw({"head.bias": entry([10**12], 0, 16)}, bytes(16)),
        raw({"head.bias": entry([4], 16, 0)}, bytes(16)),
        raw({"head.bias": entry([4], -16, 0)}, bytes(16)),
        raw({"a": entry([4], 0, 16), "b": entry([4], 8, 24)}, bytes(24)),
        raw({"head.bias": entry([4], 0, 16, "PYOBJ")}, bytes(16)),
        raw({"__metadata__": {"grasp_bench": "{"}, "head.bias": entry([4], 0, 16)}, bytes(16)),
        raw({"__metadata__": {"grasp_bench": "[1]"}, "head.bias": entry([4], 0, 16)}, bytes(16)),
        raw({"__metadata__": {"grasp_bench": "[" * 100_000}, "head.bias": entry([4], 0, 16)}, bytes(16)),
        raw({"__metadata__": {"grasp_bench": 7}, "head.bias": entry([4], 0, 16)}, bytes(16)),
    ],
)
def test_hostile_weights_are_refused_with_their_name(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    path.write_bytes(content)
    with pytest.raises(AssetError, match=r"gg-cnn\.safetensors"):
        load("gg-cnn", path)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (torch.full((4,), float("inf")), "not finite"),
        (torch.ones(4, dtype=torch.int64), "holds int64"),
        (torch.ones(4, dtype=torch.bool), "holds bool"),
        (torch.ones(4, dtype=torch.uint8), "holds uint8"),
    ],
)
def test_weights_of_the_wrong_kind_of_number(
    value: torch.Tensor, message: str, weights, tmp_path: Path
) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    save_file(load_file(weights["gg-cnn"]) | {"head.bias": value}, path)
    with pytest.raises(AssetError, match=message):
        load("gg-cnn", path)


def test_weights_of_the_same_shapes_but_another_architecture(weights, tmp_path: Path) -> None:
    path = tmp_path / "gg-cnn.safetensors"
    renamed = {key.replace("head", "tail"): value for key, value in load_file(weights["gg-cnn"]).items()}
    save_file(renamed, path)
    with pytest.raises(AssetError, match="does not fit network 'gg-cnn'"):
        load("gg-cnn", path)


def test_a_folder_is_no_weights(tmp_path: Path) -> None:
    (tmp_path / "gg-cnn.safetensors").mkdir()
    with pytest.raises(AssetError, match=r"gg-cnn\.safetensors are missing"):
        load("gg-cnn", tmp_path / "gg-cnn.safetensors")


def test_a_run_checks_shipped_weights_without_loading_the_network() -> None:
    code = (
        "import sys; from grasp_bench.predictors.identity import identify; "
        "print(identify('htc-grasp'), 'torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["None", "False"]


def test_a_run_does_not_begin_with_altered_or_missing_weights(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "weights"
    folder.mkdir()
    monkeypatch.setattr("grasp_bench.networks.store.assets_dir", lambda: tmp_path)
    with pytest.raises(AssetError, match=r"htc-grasp\.safetensors are missing; .*name a"):
        identity.identify("htc-grasp")
    (folder / "htc-grasp.safetensors").write_bytes(b"not those shipped")
    (folder / MANIFEST).write_text(json.dumps({"htc-grasp.safetensors": "0" * 64}))
    with pytest.raises(AssetError, match="does not have the SHA-256"):
        identity.identify("htc-grasp")


def test_no_tensor_of_a_network_is_named_like_the_scales_of_another() -> None:
    for name in NETWORKS:
        with torch.device("meta"):
            assert not [key for key in build(name).state_dict() if key.endswith(SCALE)]


def test_weights_too_large_for_a_file_are_stored_in_eight_bits(
    weights, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    network, _ = load("htc-grasp", weights["htc-grasp"])
    path = tmp_path / "htc-grasp.safetensors"
    save(network, path, {"network": "htc-grasp"})
    full = path.stat().st_size
    monkeypatch.setattr("grasp_bench.networks.weights.LARGEST", 0.58 * full)
    save(network, path, {"network": "htc-grasp"})
    assert path.stat().st_size < 0.6 * full
    again, _ = load("htc-grasp", path)
    for (key, value), other in zip(network.state_dict().items(), again.state_dict().values(), strict=True):
        if value.ndim >= 2 and value.is_floating_point():
            largest = value.flatten(1).abs().amax(1).reshape(-1, *[1] * (value.ndim - 1))
            assert ((value - other).abs() <= largest / 127 * 0.51).all(), key
        else:
            assert torch.equal(value, other), key


@pytest.mark.parametrize(
    "spoil",
    [
        lambda t, key: {**t, key + SCALE: torch.ones(3)},
        lambda t, key: {**t, "nowhere" + SCALE: torch.ones(3)},
        lambda t, key: {**t, key: t[key].float()},
    ],
)
def test_scales_that_fit_no_matrix(spoil, weights, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network, _ = load("htc-grasp", weights["htc-grasp"])
    path = tmp_path / "htc-grasp.safetensors"
    monkeypatch.setattr("grasp_bench.networks.weights.LARGEST", 0)
    save(network, path, {"network": "htc-grasp"})
    tensors = load_file(path)
    key = next(k for k in tensors if tensors[k].dtype == torch.int8)
    save_file(spoil(tensors, key), path)
    with pytest.raises(AssetError, match=r"\.scale does not belong to a matrix in 8 bits"):
        load("htc-grasp", path)


@pytest.mark.parametrize("name", [n for n, s in SHIPPED.items() if s.kind == "control"])
def test_controls_answer_where_nobody_called_begin(name: str) -> None:
    control = load_predictor(name)
    if isinstance(control, PrivilegedPredictor):  # it is not for images alone, but says so
        with pytest.raises(PredictorError, match="needs the simulator's truth"):
            control.predict(image())
        return
    grasps = control.predict(image())
    assert grasps or "6dof" in name  # whose cloud of this picture has nothing that jaws close on
    assert grasps == load_predictor(name).predict(image())


def test_a_network_answers_where_nobody_called_begin(weights: dict[str, Path]) -> None:
    made = load_predictor(f"gg-cnn@{weights['gg-cnn']}")
    assert not hasattr(made, "begin")
    assert made.predict(image())


# --- test-time augmentation ----------------------------------------------------------------------


def test_test_time_augmentation_asks_about_copies() -> None:
    """It has the network's own weights and calibration, answers alike for a copy, and names itself."""
    own, averaged = load_predictor("htc-grasp"), load_predictor("htc-grasp-tta")
    assert isinstance(own, NetworkPredictor)
    assert isinstance(averaged, NetworkPredictor)
    assert averaged.metadata == own.metadata
    assert SHIPPED["htc-grasp-tta"].details()["paper_rows"] == {}
    picture = image(224, 224, holes=0.0)
    turned = RgbdImage(
        picture.rgb[::-1, ::-1].copy(), picture.depth[::-1, ::-1].copy(), Intrinsics.from_fov(224, 224, 1.1)
    )

    def apart(predictor: NetworkPredictor) -> float:
        quality = predictor.maps(picture).quality
        return float(np.abs(predictor.maps(turned).quality[::-1, ::-1] - quality).max())

    assert apart(averaged) < 1e-3 < apart(own)


def test_a_detector_has_nothing_to_average() -> None:
    with pytest.raises(PredictorError, match="no maps, which test-time augmentation averages"):
        NetworkPredictor("wu-anchor-free", tta=True)
