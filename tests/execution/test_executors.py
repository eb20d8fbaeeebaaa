"""Executors: whatever a trial does to its worker, every job ends once, and the others do not notice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

import psutil
import pytest
from fake_work import FakeProcesses, until

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.execution.executors import make_executor
from grasp_bench.execution.memory import fair_share
from grasp_bench.execution.protocol import Answer, Fault
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.limits import ErrorLimit
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario

TESTS = Path(__file__).parents[1] / "support"


def settings(timeout: float = 60.0, predictor: str = "fine") -> Settings:
    return Settings(Scenario(name="quick", trial_timeout=timeout), Path(), predictor, 0, "raycast")


def carried_out(
    whats: Iterable[str],
    workers: int = 1,
    timeout: float = 60.0,
    memory_limit: int | None = None,
    recycle: int = 0,
) -> dict[int, Answer | Fault]:
    """Answers by trial of jobs that do ``whats``."""
    jobs = [Job(i, what, 0) for i, what in enumerate(whats)]
    answers = list(FakeProcesses(workers, memory_limit, recycle).run(settings(timeout), jobs))
    assert sorted(a.job.trial for a in answers) == list(range(len(jobs)))
    return {a.job.trial: a for a in answers}


def test_a_worker_that_dies_costs_its_own_trial_only() -> None:
    ended = carried_out(["fine", "segfault", "fine", "exit", "abort", "fine"], workers=2)
    assert [type(ended[i]) for i in range(6)] == [Answer, Fault, Answer, Fault, Fault, Answer]
    reasons = {i: (a.outcome, a.detail) for i, a in ended.items() if isinstance(a, Fault)}
    assert reasons == {
        1: (Outcome.ERROR, "the worker process died (killed by SIGSEGV)"),
        3: (Outcome.ERROR, "the worker process died (exit code 7)"),
        4: (Outcome.ERROR, "the worker process died (killed by SIGABRT)"),
    }


def test_endless_trials_are_ended_and_the_worker_is_replaced() -> None:
    ended = carried_out(["loop", "fine", "stuck", "fine"], timeout=4)
    assert [type(ended[i]) for i in range(4)] == [Fault, Answer, Fault, Answer]
    assert {(a.outcome, a.detail) for a in ended.values() if isinstance(a, Fault)} == {
        (Outcome.TIMEOUT, "no answer within 4 s")
    }


def test_a_worker_that_takes_too_much_memory_is_ended_with_that_reason() -> None:
    ended = carried_out(["fine", "hoard", "child-hoards", "fine"], memory_limit=400 << 20)
    assert [type(ended[i]) for i in range(4)] == [Answer, Fault, Fault, Answer]
    for i in (1, 2):
        fault = ended[i]
        assert isinstance(fault, Fault)
        assert fault.outcome is Outcome.ERROR
        assert "GiB of memory, more than the 0.4 GiB allowed" in fault.detail
    assert not [p for p in psutil.Process().children(recursive=True) if p.memory_info().rss > 300 << 20]


def test_a_trial_whose_worker_was_killed_by_somebody_else_is_done_again(tmp_path: Path) -> None:
    ended = carried_out(["fine", f"killed-once:{tmp_path / 'mark'}", "fine"])
    assert all(isinstance(a, Answer) for a in ended.values())
    assert (tmp_path / "mark").exists()


def test_a_trial_that_took_too_long_once_is_done_again(tmp_path: Path) -> None:
    ended = carried_out(["fine", f"late-once:{tmp_path / 'mark'}", "fine"], timeout=3)
    assert all(isinstance(a, Answer) for a in ended.values())
    assert (tmp_path / "mark").exists()


def test_a_clock_that_is_set_forward_makes_no_timeouts(monkeypatch: pytest.MonkeyPatch) -> None:
    true, asked = time.time, iter(range(10**9))
    monkeypatch.setattr(time, "time", lambda: true() + 1e4 * next(asked))
    monkeypatch.setenv("FAKE_WORK_SECONDS", "0.5")
    assert all(isinstance(a, Answer) for a in carried_out(["fine"] * 3, timeout=30).values())


def test_a_time_limit_that_no_clock_holds_is_cut() -> None:
    assert all(isinstance(a, Answer) for a in carried_out(["fine"], timeout=1e300).values())


def test_a_process_that_leaves_with_status_0_died_and_a_recycled_one_did_not() -> None:
    ended = carried_out(["fine", "exit-0", "fine", "fine"], recycle=2)
    assert [type(ended[i]) for i in range(4)] == [Answer, Fault, Answer, Answer]
    fault = ended[1]
    assert isinstance(fault, Fault)
    assert fault.detail == "the worker process died (exit code 0)"


def test_workers_do_not_import_the_files_of_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    for name in ("socket", "signal", "selectors", "tempfile", "numpy", "random"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'PWNED')!r}, 'a').write('{name} ')\n")
    assert all(isinstance(a, Answer) for a in carried_out(["fine"] * 2).values())
    assert not (tmp_path / "PWNED").exists()
    assert "PYTHONSAFEPATH" not in os.environ


def test_workers_are_recycled_and_use_one_thread_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    ended = carried_out(["fine"] * 6, recycle=2)
    records = [a.record for a in ended.values() if isinstance(a, Answer)]
    assert len({r.to_json()["pid"] for r in records}) == 3
    assert {r.to_json()["threads"] for r in records} == {"1"}
    assert os.environ["OMP_NUM_THREADS"] == "7"


def test_jobs_are_taken_as_they_are_needed() -> None:
    taken = []

    def jobs() -> Iterator[Job]:
        for i in range(100_000):
            taken.append(i)
            yield Job(i, "fine", 0)

    with closing(FakeProcesses(2).run(settings(), jobs())) as answers:
        for _ in range(5):
            next(answers)
    assert len(taken) <= 5 + 2 * 2 * 2
    assert not [p for p in psutil.Process().children() if "spawn_main" in " ".join(p.cmdline())]


def test_nothing_to_do_starts_nothing() -> None:
    assert list(FakeProcesses(2).run(settings(), [])) == []


def test_workers_that_cannot_start_end_the_run_with_the_reason() -> None:
    with pytest.raises(GraspBenchError, match="A worker could not start: RuntimeError: no weights here"):
        list(FakeProcesses(1).run(settings(predictor="unstartable"), [Job(0, "fine", 0)]))


PARENT = """
import sys
sys.path[:0] = {tests!r}
from test_executors import settings
from fake_work import FakeProcesses, until
from grasp_bench.runs.jobs import Job
list(FakeProcesses(1).run(settings(600), [Job(0, "wait:{mark}", 0)]))
"""


def test_workers_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    mark = tmp_path / "pid"
    folders = [str(TESTS), str(Path(__file__).parent)]
    parent = subprocess.Popen([sys.executable, "-c", PARENT.format(tests=folders, mark=mark)])
    try:
        until(lambda: mark.is_file() and mark.read_text().isdigit())
        worker = psutil.Process(int(mark.read_text()))
        parent.send_signal(signal.SIGKILL)
        parent.wait(30)
        until(lambda: not worker.is_running() or worker.status() == psutil.STATUS_ZOMBIE)
    finally:
        parent.kill()


def test_an_unknown_executor_is_refused_by_the_nearest_name() -> None:
    with pytest.raises(UnknownNameError, match=r"Unknown executor 'rai'\. Did you mean ray"):
        make_executor("rai", 1)


def test_a_ray_address_without_ray_is_refused() -> None:
    with pytest.raises(GraspBenchError, match="--ray-address needs --executor ray"):
        make_executor("process", 1, ray_address="auto")


def test_ray_that_is_not_installed_is_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(GraspBenchError, match=r"needs Ray, which is not installed.*grasp-bench\[ray\]"):
        make_executor("ray", 1)


def test_a_workers_share_of_the_memory_is_less_with_more_workers() -> None:
    assert fair_share(1) == int(0.8 * psutil.virtual_memory().total)
    assert fair_share(40) == pytest.approx(fair_share(1) / 40, abs=1)


# ---------------------------------------------------------------- how many errors are too many


@pytest.mark.parametrize(
    ("text", "faults", "trials", "exceeded"),
    [
        ("0", 0, 10, False),
        ("0", 1, 10, True),
        ("3", 3, 10, False),
        ("3", 4, 10, True),
        ("2%", 2, 100, False),
        ("2%", 3, 100, True),
        ("0.5 %", 1, 200, False),
        ("0.5%", 2, 200, True),
        ("100%", 5, 5, False),
        ("0%", 1, 1000, True),
    ],
)
def test_errors_are_allowed_by_number_or_share(text: str, faults: int, trials: int, exceeded: bool) -> None:
    assert ErrorLimit.parse(text).exceeded(faults, trials) is exceeded


@pytest.mark.parametrize("text", ["", "-1", "1.5", "some", "101%", "2 per cent", "nan", "%"])
def test_other_limits_are_refused(text: str) -> None:
    with pytest.raises(GraspBenchError, match="--max-errors must be a number of trials"):
        ErrorLimit.parse(text)
