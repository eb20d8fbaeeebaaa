"""Scripts in ``benchmarks/``: what of them can go wrong without being measured."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest
import torch

from grasp_bench.learning.data.scenes import SceneSet
from grasp_bench.learning.training.config import TrainConfig

FOLDER = Path(__file__).parents[1] / "benchmarks"


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"benchmark_{name}", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_gpus_part_of_latency_runs_on_any_device() -> None:
    latency, cpu = script("latency"), torch.device("cpu")
    figures = latency.measure_on(cpu, ["gg-cnn", "htc-grasp-no-ea"], repeats=1, batches=(1, 2))
    assert set(figures) == {
        (batch, mode, name)
        for batch in (1, 2)
        for mode in ("fp32", "bf16")
        for name in ("gg-cnn", "htc-grasp-no-ea")
    }
    assert all(value > 0 for value in figures.values())
    output = latency.on_device("gg-cnn", "bf16", 2, cpu)()
    assert output.shape == (2, 4, 224, 224)
    assert output.dtype == torch.bfloat16
    assert {row[0] for row in latency.table(figures, 2, "two", 1).rows} == {"gg-cnn", "htc-grasp-no-ea"}


def test_ratios_of_latency_stand_beside_the_papers() -> None:
    latency = script("latency")
    slow = {"gr-convnet": 240.0, "htc-grasp": 40.0, "gr-convnet-16": 80.0}
    figures = {
        (1, mode, name): ms * s for mode, s in (("fp32", 2), ("fp32 cl", 1)) for name, ms in slow.items()
    }
    told = latency.table(figures, 1, "one", 5)
    assert [row[0] for row in told.rows] == ["htc-grasp", "gr-convnet-16", "gr-convnet"], "fastest first"
    assert told.rows[0] == ["htc-grasp", "2,434,004", "80.0", "40.0", "6.0", "", "5.4", "3.7", "7.7"]
    assert told.rows[1][4:] == ["3.0", "", "", "", ""], "the paper has no such row, and no tf-grasp was timed"


def test_latency_says_what_its_gpu_part_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    latency = script("latency")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(torch.version, "cuda", None)
    assert "PyTorch built for CUDA" in latency.missing_cuda()
    monkeypatch.setattr(torch.version, "cuda", "13.0")
    assert "driver for CUDA 13.0" in latency.missing_cuda()
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert latency.missing_cuda() is None
    assert "fp32 graph" in latency.modes_of(torch.device("cuda"))


def test_the_parts_of_a_training_step_are_those_of_the_training() -> None:
    training = script("training")
    config = TrainConfig(network="gg-cnn", steps=training.WARM_UP + 1, batch=1, threads=1, precision="fp32")
    spent = training.parts(config, SceneSet([training.made_up()], [], ""))
    assert list(spent) == ["load", "forward", "backward", "optimiser"]
    assert all(processor > 0 for _, processor in spent.values())
