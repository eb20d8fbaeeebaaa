"""Runs that are killed, stopped, or meet a folder they cannot write to: nothing measured is lost."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
from fake_work import until

import grasp_bench as gb
from grasp_bench.predictors.controls import Antipodal
from grasp_bench.scenario.sections import Scenario

TESTS = Path(__file__).parents[1] / "support"


class Command:
    """``grasp-bench run`` as a process of its own."""

    def __init__(self, cwd: Path, arguments: str, code: str | None = None, **environment: str) -> None:
        start = ["-m", "grasp_bench.cli"] if code is None else ["-c", code]
        self.process = subprocess.Popen(
            [sys.executable, *start, "run", *arguments.split()],
            cwd=cwd,
            text=True,
            start_new_session=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=os.environ | environment | {"PYTHONPATH": f"{TESTS.parents[1]}:{TESTS}"},
        )

    def workers(self) -> list[psutil.Process]:
        """Its worker processes."""
        children = psutil.Process(self.process.pid).children()
        return [p for p in children if "spawn_main" in " ".join(p.cmdline())]

    def end(self) -> tuple[int, str]:
        """Exit code and output."""
        out, _ = self.process.communicate(timeout=600)
        return self.process.returncode, out


def lines(folder: Path) -> int:
    path = folder / "trials.jsonl"
    return path.read_bytes().count(b"\n") if path.is_file() else 0


def alive(processes: list[psutil.Process]) -> list[psutil.Process]:
    return [p for p in processes if p.is_running() and p.status() != psutil.STATUS_ZOMBIE]


def test_kill_9_of_parent_and_worker_lose_nothing_and_change_nothing(
    toy_catalog: Path, scenario: Scenario, tmp_path: Path
) -> None:
    """Killed midway, resumed, a worker killed midway through that: the bytes of an unbroken run."""
    unbroken = gb.run(toy_catalog, 9, Antipodal(), scenario, seed=2, out=tmp_path / "one", progress=False)
    (tmp_path / "quick.yaml").write_text(scenario.model_dump_json())
    out = tmp_path / "killed"
    asked = (
        f"--objects {toy_catalog} --trials 9 --predictor antipodal --seed 2 --out {out} "
        "--scenario quick.yaml --workers 1"
    )

    first = Command(tmp_path, asked)
    until(lambda: lines(out) >= 2)
    workers = first.workers()
    first.process.kill()
    first.end()
    until(lambda: not alive(workers), 60)
    kept = lines(out)
    assert 2 <= kept < 9

    second = Command(tmp_path, asked)
    until(lambda: lines(out) > kept)
    for worker in second.workers():
        worker.kill()
    code, text = second.end()
    assert code == 0, text
    assert f"{kept} trials were done, {9 - kept} added" in " ".join(text.split())
    assert (out / "trials.jsonl").read_bytes() == (unbroken.folder / "trials.jsonl").read_bytes()


SLOW = """
from fake_work import FakeProcesses
from grasp_bench import api
api.make_executor = lambda name, workers, **_: FakeProcesses(workers)
from grasp_bench.cli import main
main()
"""


@pytest.fixture
def asked(toy_catalog: Path) -> str:
    """Arguments of a run of 40 trials."""
    return f"--objects {toy_catalog} --trials 40 --predictor oracle --out out --workers 2"


@pytest.mark.parametrize("how", ["Ctrl-C", "SIGTERM"])
def test_a_stopped_run_ends_its_workers_and_says_how_to_go_on(asked: str, tmp_path: Path, how: str) -> None:
    run = Command(tmp_path, asked, SLOW, FAKE_WORK_SECONDS="0.5")
    until(lambda: lines(tmp_path / "out") >= 3)
    workers = run.workers()
    assert workers
    if how == "Ctrl-C":  # the terminal sends it to all processes in front
        os.killpg(run.process.pid, signal.SIGINT)
    else:
        run.process.terminate()
    code, text = run.end()
    assert code == 130, text
    assert "What was measured is kept; the same command goes on from here" in text
    assert "Traceback" not in text
    assert not alive(workers)
    kept = lines(tmp_path / "out")
    assert 3 <= kept < 40
    code, text = Command(tmp_path, asked, SLOW).end()
    assert code == 0, text
    assert f"{kept} trials were done, {40 - kept} added" in " ".join(text.split())
    written = (tmp_path / "out" / "trials.jsonl").read_text().splitlines()
    assert [json.loads(line)["trial"] for line in written] == list(range(40))


def test_a_second_run_into_the_folder_is_refused_while_the_first_goes_on(asked: str, tmp_path: Path) -> None:
    first = Command(tmp_path, asked, SLOW, FAKE_WORK_SECONDS="0.5")
    until(lambda: lines(tmp_path / "out") >= 1)
    code, text = Command(tmp_path, asked, SLOW).end()
    assert code == 2
    assert "Another run is writing to" in text
    first.process.terminate()
    assert first.end()[0] == 130


@pytest.mark.parametrize("where", ["/proc/grasp-bench", "/dev/null/out"])
def test_a_folder_that_cannot_be_written_is_one_clear_error(asked: str, tmp_path: Path, where: str) -> None:
    code, text = Command(tmp_path, asked.replace("--out out", f"--out {where}"), SLOW).end()
    assert code == 2
    assert f"{where} cannot be written" in " ".join(text.split())
    assert "Traceback" not in text
