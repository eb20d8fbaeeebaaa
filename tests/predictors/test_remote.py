"""Predictors behind an address or a command: the same records as local ones, no harm from hostile ones."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import uvicorn

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import PredictorError, ResultsError
from grasp_bench.execution.runner import run
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.command import CommandPredictor
from grasp_bench.predictors.protocol import ask
from grasp_bench.predictors.remote import RemotePredictor, UnansweredError, is_loopback
from grasp_bench.predictors.server import listen, make_app, servable
from grasp_bench.runs.jobs import Settings, spread

DEPTH = np.full((48, 64), 0.55, np.float32)
DEPTH[20:28, 28:36] = 0.5
IMAGE = RgbdImage(np.zeros((48, 64, 3), np.uint8), DEPTH, Intrinsics.from_fov(64, 48, np.pi / 2))
GRASP = {"x": 3.0, "y": 3.0, "angle": 0.0, "width": 5.0, "quality": 1.0}


def predict(predictor: Any, seed: int = 0) -> list[Any]:
    return ask(predictor, IMAGE, np.random.default_rng(seed))


@contextmanager
def served(name: str) -> Iterator[str]:
    """A shipped predictor at an address, served by a thread."""
    app = make_app(*servable(name))
    server = uvicorn.Server(uvicorn.Config(app, log_level="warning", lifespan="off"))
    listener = listen("127.0.0.1", 0)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}"
    finally:
        server.should_exit = True
        thread.join(10)
        listener.close()


# ---------------------------------------------------------------- the same as local


@pytest.fixture(scope="module")
def addresses() -> Iterator[dict[str, str]]:
    with served("random") as first, served("antipodal") as second:
        yield {"random": first, "antipodal": second}


def trials(folder: Path) -> bytes:
    return (folder / "trials.jsonl").read_bytes()


@pytest.mark.parametrize("name", ["random", "antipodal"])
def test_a_served_predictor_writes_the_records_of_a_local_one_to_the_byte(
    name: str, addresses: dict[str, str], scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    jobs = spread(["bar", "block", "pot"], 3)
    local = Settings(scenario, toy_catalog, name, 5, "raycast")
    run(local, jobs, tmp_path / "local", 1)
    run(replace(local, predictor=addresses[name]), jobs, tmp_path / "served", 2)
    assert trials(tmp_path / "served") == trials(tmp_path / "local")
    assert b'"error"' not in trials(tmp_path / "local")
    described = json.loads((tmp_path / "served" / "run.json").read_text())
    assert described["implementation"]["info"]["predictor"] == name
    assert described["implementation"]["info"]["software"].startswith("grasp-bench ")


def test_grasps_and_their_chances_are_those_of_the_local_predictor(addresses: dict[str, str]) -> None:
    local, remote = load_predictor("random"), RemotePredictor(addresses["random"])
    for seed in range(5):
        assert predict(remote, seed) == predict(local, seed)
    assert len({predict(remote, seed)[0].angle for seed in range(5)}) == 5


class Faulty:
    """Raises, or answers outside the image."""

    def predict(self, image: RgbdImage) -> list[Any]:
        raise ValueError("no idea")


def test_what_a_served_predictor_raises_reads_as_if_it_were_local() -> None:
    messages = []
    with served("test_remote:Faulty") as address:
        for predictor in (Faulty(), RemotePredictor(address)):
            with pytest.raises(PredictorError) as caught:
                predict(predictor)
            messages.append(str(caught.value))
    assert messages[0] == messages[1]
    assert re.fullmatch(r"the predictor raised ValueError: no idea \(test_remote\.py:\d+\)", messages[0])


def test_it_works_inside_a_running_event_loop(addresses: dict[str, str]) -> None:
    import asyncio

    async def notebook() -> int:
        return len(predict(RemotePredictor(addresses["random"])))

    assert asyncio.run(notebook()) == 1


# ---------------------------------------------------------------- hostile servers


class Hostile(BaseHTTPRequestHandler):
    """Answers as the class attribute says."""

    play: Callable[[Any], None]

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        type(self).play(self)

    def do_GET(self) -> None:
        type(self).play(self)

    def log_message(self, format: str, *args: object) -> None:
        pass


@contextmanager
def hostile(play: Callable[[Any], None]) -> Iterator[str]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), type("Play", (Hostile,), {"play": staticmethod(play)}))
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}"
    finally:
        server.shutdown()
        server.server_close()


def reply(status: int = 200, body: bytes = b"", **headers: str) -> Callable[[Any], None]:
    def play(handler: Any) -> None:
        handler.send_response(status)
        for key, value in headers.items():
            handler.send_header(key.replace("_", "-"), value)
        handler.end_headers()
        handler.wfile.write(body)

    return play


def grasps(**changed: Any) -> bytes:
    return json.dumps({"grasps": [GRASP | changed]}).encode()


def drip(handler: Any) -> None:
    """A byte now and then, for ever: no single read is slow."""
    handler.send_response(200)
    handler.end_headers()
    while True:
        handler.wfile.write(b" ")
        handler.wfile.flush()
        time.sleep(0.05)


def drip_headers(handler: Any) -> None:
    handler.wfile.write(b"HTTP/1.0 200 OK\r\n")
    while True:
        handler.wfile.write(b"X: y\r\n")
        handler.wfile.flush()
        time.sleep(0.05)


def flood(handler: Any) -> None:
    handler.send_response(200)
    handler.end_headers()
    for _ in range(100_000):
        handler.wfile.write(b" " * 65536)


def hang_up(handler: Any) -> None:
    handler.close_connection = True
    handler.connection.shutdown(socket.SHUT_RDWR)


@pytest.mark.parametrize(
    ("play", "reason"),
    [
        (reply(body=b"<html>"), "not JSON"),
        (reply(body=b""), "not JSON"),
        (reply(body=grasps(x=float("nan"))), "NaN is not a number"),
        (reply(body=grasps(x=1e400)), "Infinity is not a number"),
        (reply(body=grasps(x=64.5)), r"outside the 64×48 image"),
        (reply(body=grasps(y=-1)), "outside the"),
        (reply(body=grasps(width=0)), "must be positive"),
        (reply(body=grasps(angle="up")), "angle must be a number"),
        (reply(body=b'{"grasps": [[1, 2, 3, 4]]}'), "must have x, y, angle"),
        (reply(body=json.dumps({"grasps": [GRASP] * 1001}).encode()), "1001 grasps are too many"),
        (reply(302, Location="http://example.com/"), "redirects to http://example.com/"),
        (reply(307, Location="file:///etc/passwd"), "redirects to file:///etc/passwd"),
        (reply(body=b"\x1f\x8b" + bytes(100), Content_Encoding="gzip"), "answered compressed"),
        (reply(404, b"nothing here"), "status 404"),
        (reply(500, b'{"error": "out of memory"}'), "^out of memory$"),
        (reply(500, b'{"error": "' + b"x" * 99_999 + b'"}'), "^x{1000}$"),
        (reply(500, b'{"error": {"is": "odd"}}'), "status 500"),
        (reply(204), "status 204"),
        (reply(200, b"{}", Content_Length="50"), "broke off"),
        (lambda h: h.wfile.write(b"SSH-2.0-OpenSSH_9.2\r\n"), "broke off"),
        (flood, "more than 1048576 bytes"),
        (hang_up, "broke off"),
        (drip, "no answer within 0.7 s"),
        (drip_headers, "no answer within 0.7 s"),
        (lambda h: time.sleep(5), "no answer within 0.7 s"),
    ],
)
def test_a_hostile_answer_is_refused_with_a_reason(play: Callable[[Any], None], reason: str) -> None:
    slow = "no answer" in reason
    with hostile(play) as address:
        predictor = RemotePredictor(address, seconds=0.7 if slow else 60)
        with pytest.raises(PredictorError, match=reason):
            predict(predictor)
        predictor.close()


def test_a_hostile_answer_ends_its_trial_as_an_error_with_the_reason(
    scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    def play(handler: Any) -> None:
        reply(body=b'{"protocol": 1}' if handler.path == "/info" else grasps(x=-40.0))(handler)

    with hostile(play) as address:
        settings = Settings(scenario, toy_catalog, address, 0, "raycast")
        run(settings, spread(["bar"], 1), tmp_path, 1)
    record = json.loads(trials(tmp_path))
    assert record["outcome"] == "error"
    assert "grasp 0 at (-40.0, 3.0) px is outside" in record["detail"]


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (b"{}", "protocol None, not 1 or 2"),
        (b'{"protocol": 99}', "protocol 99, not 1 or 2"),
        (b"[1]", "a JSON object"),
        (b'{"protocol": 1, "x": "' + b"y" * 70_000 + b'"}', "more than 65536 bytes"),
        (b"\x00", "not JSON"),
    ],
)
def test_a_server_of_something_else_is_recognised(body: bytes, reason: str) -> None:
    with hostile(reply(body=body)) as address, pytest.raises(PredictorError, match=reason):
        RemotePredictor(address).info()


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("http://", "not the address of a server"),
        ("http://127.0.0.1:0", "not the address of a server"),
        ("http://127.0.0.1:99999", "not the address"),
        ("http://[::1", "not an address"),
        ("http://127.0.0.1:80/?q=1", "not the address of a server"),
        ("http://a b:80", "not the address"),
        ("http://me:secret@127.0.0.1:80", "Leave name and password out"),
    ],
)
def test_an_impossible_address_is_refused(address: str, reason: str) -> None:
    with pytest.raises(PredictorError, match=reason) as caught:
        load_predictor(address)
    assert "secret" not in str(caught.value)


def test_nobody_listening_is_said_and_a_server_that_comes_back_is_waited_for() -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    late = RemotePredictor(f"http://127.0.0.1:{port}", seconds=0.3)
    with pytest.raises(UnansweredError, match=f"nothing listens at http://127.0.0.1:{port}"):
        predict(late)
    patient = RemotePredictor(f"http://127.0.0.1:{port}", seconds=60)

    def come_back() -> None:
        time.sleep(0.3)
        with ThreadingHTTPServer(
            ("127.0.0.1", port), type("Play", (Hostile,), {"play": staticmethod(reply(body=grasps()))})
        ) as server:
            server.handle_request()

    thread = threading.Thread(target=come_back)
    thread.start()
    assert len(predict(patient)) == 1
    thread.join()


def test_environment_proxies_do_not_see_a_loopback_request(
    addresses: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("HTTP_PROXY", "http_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    assert RemotePredictor(addresses["random"]).info()["protocol"] == 2


def test_loopback_is_told_from_the_rest() -> None:
    assert all(map(is_loopback, ["127.0.0.1", "127.8.8.8", "::1", "localhost"]))
    assert not any(map(is_loopback, ["0.0.0.0", "::", "192.168.1.4", "example.com"]))


# ---------------------------------------------------------------- commands

SERVER = """
import json, os, sys, time
from http.server import BaseHTTPRequestHandler, HTTPServer
port, mode = int(sys.argv[1]), sys.argv[2]
print("loading", flush=True)
if mode == "broken": sys.exit("no such weights")
open(sys.argv[3], "a").write(f"{os.getpid()}\\n")
class Handler(BaseHTTPRequestHandler):
    def do_GET(self): self.say({"protocol": 1, "mode": mode})
    def do_POST(self):
        self.rfile.read(int(self.headers["Content-Length"]))
        started = len(open(sys.argv[3]).readlines())
        if mode == "dies" and started == 1: os._exit(9)
        if mode == "hangs" and started == 1: time.sleep(600)
        if mode == "chatty": print("x" * 3_000_000, flush=True)
        self.say({"grasps": []})
    def say(self, content):
        body = json.dumps(content).encode()
        self.send_response(200); self.end_headers(); self.wfile.write(body)
    def log_message(self, *_): pass
if mode == "deaf": time.sleep(600)
HTTPServer(("127.0.0.1", port), Handler).serve_forever()
"""


@pytest.fixture
def command(tmp_path: Path) -> Callable[[str], str]:
    (tmp_path / "server.py").write_text(SERVER)
    return lambda mode: f"{sys.executable} -S {tmp_path}/server.py {{port}} {mode} {tmp_path}/pids"


def pids(tmp_path: Path) -> list[int]:
    return [int(line) for line in (tmp_path / "pids").read_text().split()]


def gone(pid: int, seconds: float = 60) -> bool:
    """Whether a process ends within some time."""
    for _ in range(int(seconds / 0.05)):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def test_a_command_is_started_asked_and_stopped(command, tmp_path: Path) -> None:
    predictor = load_predictor("cmd: " + command("fine"))
    assert isinstance(predictor, CommandPredictor)
    assert predict(predictor) == []
    assert predictor.info() == {"protocol": 1, "mode": "fine"}
    predictor.close()
    assert [gone(pid) for pid in pids(tmp_path)] == [True]
    assert predict(predictor) == []  # one that was closed starts again
    predictor.close()
    assert all(map(gone, pids(tmp_path)))


@pytest.mark.parametrize(
    ("mode", "reason"),
    [("dies", r"process died \(exit code 9\); it printed: loading"), ("hangs", "no answer within 2 s")],
)
def test_a_server_that_dies_or_hangs_costs_one_trial(mode: str, reason: str, command, tmp_path: Path) -> None:
    predictor = CommandPredictor(command(mode), seconds=2)
    with pytest.raises(PredictorError, match=reason):
        predict(predictor)
    predictor._seconds = 60
    assert predict(predictor) == []
    first, second = pids(tmp_path)
    assert gone(first)
    predictor.close()
    assert gone(second)


def test_a_command_that_ends_or_stays_silent_is_refused_with_what_it_printed(command, tmp_path: Path) -> None:
    with pytest.raises(PredictorError, match=r"exit code 1\); it printed: loading \| no such weights"):
        CommandPredictor(command("broken"))
    with pytest.raises(PredictorError, match=r"did not answer GET /info.*within 4 s"):
        CommandPredictor(command("deaf"), start_seconds=4)  # Python takes a second to start on a busy machine
    assert all(map(gone, pids(tmp_path)))


def test_what_a_server_prints_does_not_fill_the_disk(command) -> None:
    predictor = CommandPredictor(command("chatty"))
    for _ in range(3):
        predict(predictor)
    assert os.fstat(predictor._log.fileno()).st_size < 4_000_000
    predictor.close()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no place for the port"),
        ("python server.py", r"no place for the port: write \{port\}"),
        ("python 'server.py {port}", "cannot be split"),
        ("no-such-program {port}", "'no-such-program'.*not found"),
    ],
)
def test_an_impossible_command_is_refused(text: str, reason: str) -> None:
    with pytest.raises(PredictorError, match=reason):
        load_predictor("cmd:" + text)


def test_a_command_is_not_given_to_a_shell(command, tmp_path: Path) -> None:
    predictor = CommandPredictor(f"{command('fine')} ; touch {tmp_path}/evil $(touch {tmp_path}/worse)")
    predictor.close()
    assert not (tmp_path / "evil").exists()
    assert not (tmp_path / "worse").exists()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_the_server_ends_with_its_worker_however_that_dies(number: int, command, tmp_path: Path) -> None:
    code = (
        "import time\nfrom grasp_bench.predictors import load_predictor\n"
        f"load_predictor({'cmd: ' + command('fine')!r})\nprint('ready', flush=True)\ntime.sleep(600)"
    )
    worker = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert worker.stdout is not None
    assert worker.stdout.readline() == b"ready\n"
    (pid,) = pids(tmp_path)
    os.kill(pid, 0)
    worker.send_signal(number)
    worker.wait(timeout=60)
    worker.stdout.close()
    assert gone(pid)


def test_a_run_by_a_command_starts_one_server_a_worker_and_leaves_none(
    command, scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    settings = Settings(scenario, toy_catalog, "cmd:" + command("fine"), 0, "raycast")
    run(settings, spread(["bar", "block"], 2), tmp_path / "out", 2)
    outcomes = [json.loads(line)["outcome"] for line in trials(tmp_path / "out").splitlines()]
    assert outcomes == ["no_grasp", "no_grasp"]
    started = pids(tmp_path)
    # One to see that it works before the first trial, and two workers'; one may do both trials alone.
    assert len(started) in (2, 3)
    assert all(map(gone, started))
    (tmp_path / "server.py").write_text(SERVER + "# changed\n")
    with pytest.raises(ResultsError, match="the predictor's files, package or what it says"):
        run(settings, spread(["bar", "block"], 2), tmp_path / "out", 2)
