"""``grasp-bench serve``: what it answers, what it refuses, and whom it listens to."""

from __future__ import annotations

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from test_wire import HOSTILE, IMAGE, SEED, packed

from grasp_bench.camera import RgbdImage
from grasp_bench.cli import main
from grasp_bench.errors import GraspBenchError, PredictorError
from grasp_bench.grasps import Grasp
from grasp_bench.predictors import server, wire
from grasp_bench.predictors.identity import describe
from grasp_bench.predictors.protocol import checked
from grasp_bench.predictors.server import listen, make_app, servable


class Drawn:
    """Draws one number a trial, and remembers how many images are looked at once."""

    def __init__(self) -> None:
        self.busy = self.most = 0

    def begin(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def predict(self, image: RgbdImage) -> list[Grasp]:
        self.busy += 1
        self.most = max(self.most, self.busy)
        image.depth[:] = 0
        grasp = Grasp(1 + float(self._rng.random()), 2, 3 * np.pi / 4, 5, 2.0)
        self.busy -= 1
        return [grasp]


def asked(app: Any, *requests: tuple[str, str, Any]) -> list[httpx.Response]:
    """Answers to requests that are made at the same time."""

    async def ask() -> list[httpx.Response]:
        transport = httpx.ASGITransport(app=app, raise_app_exceptions=True)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
            calls: list[Awaitable[httpx.Response]] = [
                client.request(method, path, content=body) for method, path, body in requests
            ]
            return list(await asyncio.gather(*calls))

    return asyncio.run(ask())


def test_an_image_is_answered_with_checked_grasps_of_the_trials_stream() -> None:
    (answer,) = asked(make_app(Drawn(), {}), ("POST", "/predict", wire.encode_request(IMAGE, SEED)))
    assert answer.status_code == 200
    (grasp,) = wire.decode_answer(answer.content)
    assert isinstance(grasp, Grasp)
    assert grasp.x == 1 + np.random.default_rng(5).random()
    assert grasp.angle == pytest.approx(-np.pi / 4)
    assert grasp.quality == 1


def test_requests_at_once_are_answered_one_after_the_other_each_with_its_own_stream() -> None:
    predictor = Drawn()
    seeds = [wire.seed_of(np.random.default_rng(i)) for i in range(12)]
    answers = asked(
        make_app(predictor, {}), *[("POST", "/predict", wire.encode_request(IMAGE, s)) for s in seeds]
    )
    assert [
        checked(wire.decode_answer(a.content), IMAGE.intrinsics)[0].x - 1 for a in answers
    ] == pytest.approx([np.random.default_rng(i).random() for i in range(12)], abs=1e-12)
    assert predictor.most == 1


def test_info_tells_protocol_software_and_weights() -> None:
    (answer,) = asked(make_app(*servable("random")), ("GET", "/info", b""))
    info = answer.json()
    assert info.pop("software").startswith("grasp-bench ")
    assert info == {"protocol": 2, "predictor": "random"}
    info = describe("htc-grasp", None)
    assert len(info["files"]["htc-grasp.safetensors"]) == 64


# ---------------------------------------------------------------- hostile requests


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_body_is_answered_with_400_and_a_reason(name: str) -> None:
    body, _ = HOSTILE[name]
    app = make_app(Drawn(), {}, limit=10**6)
    refused, sound = asked(app, ("POST", "/predict", body), ("POST", "/predict", packed()))
    assert refused.status_code == 400
    assert refused.json()["error"]
    assert sound.status_code == 200, "and the server goes on"


def test_a_body_over_the_limit_is_answered_with_413_before_it_is_read() -> None:
    async def endless() -> Any:
        for _ in range(10_000):
            yield bytes(10_000)
        raise AssertionError("all of it was read")

    app = make_app(Drawn(), {}, limit=50_000)
    declared, streamed = asked(app, ("POST", "/predict", bytes(50_001)), ("POST", "/predict", endless()))
    assert [declared.status_code, streamed.status_code] == [413, 413]
    assert "more than 50000 bytes" in declared.json()["error"]


def test_a_body_that_never_ends_is_answered_with_408(monkeypatch: pytest.MonkeyPatch) -> None:
    async def dripping() -> Any:
        while True:
            yield b"x"
            await asyncio.sleep(0.01)

    monkeypatch.setattr(server, "BODY_SECONDS", 0.1)
    (answer,) = asked(make_app(Drawn(), {}), ("POST", "/predict", dripping()))
    assert answer.status_code == 408


def test_other_paths_and_methods_are_refused() -> None:
    app = make_app(Drawn(), {})
    answers = asked(app, ("GET", "/predict", b""), ("POST", "/info", b""), ("GET", "/../etc/passwd", b""))
    assert [a.status_code for a in answers] == [405, 405, 404]


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (lambda image: 1 / 0, "the predictor raised ZeroDivisionError"),
        (lambda image: [Grasp(-1, 0, 0, 1)], "outside the"),
        (lambda image: "grasp it", "must return a list"),
        (lambda image: sys.exit(3), "the predictor raised SystemExit: 3"),
    ],
)
def test_a_predictor_that_fails_is_answered_with_500_and_the_reason(
    answer: Callable[[RgbdImage], Any], reason: str
) -> None:
    class Failing(Drawn):
        def predict(self, image: RgbdImage) -> list[Grasp]:
            return answer(image)

    (failed,) = asked(make_app(Failing(), {}), ("POST", "/predict", packed()))
    assert failed.status_code == 500
    assert reason in failed.json()["error"]


# ---------------------------------------------------------------- the command


@pytest.mark.parametrize("name", ["oracle", "displaced"])
def test_privileged_controls_are_not_served(name: str) -> None:
    with pytest.raises(PredictorError, match=f"{name} cannot be served: it is a control that needs"):
        servable(name)


def test_a_taken_port_is_refused() -> None:
    first = listen("127.0.0.1", 0)
    port = first.getsockname()[1]
    with pytest.raises(GraspBenchError, match=f"Nothing can listen at 127.0.0.1:{port}.*another --port"):
        listen("127.0.0.1", port)
    first.close()
    with pytest.raises(GraspBenchError, match="Nothing can listen at"):
        listen("no-such-host.invalid", 8000)


def test_serve_listens_to_this_machine_alone_unless_told_otherwise(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    heard = []
    monkeypatch.setattr(server, "serve", lambda app, listener: heard.append(listener.getsockname()[0]))

    def serve(*options: str) -> str:
        monkeypatch.setattr("sys.argv", ["grasp-bench", "serve", "random", "--port", "0", *options])
        with pytest.raises(SystemExit) as caught:
            main()
        assert not caught.value.code
        return capsys.readouterr().err

    assert "Warning" not in serve()
    assert "whoever reaches this machine can use it" in serve("--host", "0.0.0.0")
    assert heard == ["127.0.0.1", "0.0.0.0"]


def test_a_server_says_where_it_is_and_ends_well_when_interrupted() -> None:
    command = [sys.executable, "-m", "grasp_bench.cli", "serve", "random", "--port", "0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    said = process.stderr.readline()
    address = said.split()[3]
    assert httpx.get(f"{address}/info", trust_env=False, timeout=60).json()["predictor"] == "random"
    process.send_signal(signal.SIGINT)
    rest = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 0
    assert "Traceback" not in rest
    assert "What was measured" not in rest


def test_a_served_file_of_ones_own_is_identified(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "served_module.py").write_text(
        "class Mine:\n    def predict(self, image): return []\n    def info(self): return {'epoch': 7}\n"
    )
    _, facts = servable("served_module:Mine")
    assert facts["info"] == {"epoch": 7}
    assert list(facts["files"]) == ["served_module.py"]
    assert json.loads(json.dumps(facts)) == facts
