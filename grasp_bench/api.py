"""The Python API of a whole run, which ``grasp-bench run`` calls, too."""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from grasp_bench.errors import GraspBenchError, PredictorError, UnknownNameError
from grasp_bench.execution.crew import early_crew
from grasp_bench.execution.executors import make_executor
from grasp_bench.execution.runner import RunSummary
from grasp_bench.execution.runner import run as run_trials
from grasp_bench.media.modes import check_mode
from grasp_bench.objects.catalog import Catalog, ObjectModel, folder_of
from grasp_bench.objects.difficulty import check_graded
from grasp_bench.objects.fitted import graspable, is_reference
from grasp_bench.predictors.guard import Guard
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.report.run import Run
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.runs.info import RUN
from grasp_bench.runs.jobs import WHOLE, Settings, Shard, spread
from grasp_bench.runs.limits import MOST_TRIALS, check_seed
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.reading import known_within_reach, load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system import cache
from grasp_bench.system.graphics import prepare, resolve_renderer
from grasp_bench.system.interrupts import told_apart
from grasp_bench.system.progress import Progress
from grasp_bench.system.texts import legible, shown

PathLike = str | os.PathLike[str]
OnTrial = Callable[[TrialRecord, bool], None]


class FinishedRun(Run):
    """A :class:`Run` with a ``summary`` of the call that made it: trials found done, and added.

    ``left_out`` are the objects asked for that the robot's gripper cannot grasp in any resting pose.
    """

    def __init__(self, summary: RunSummary, left_out: tuple[str, ...] = ()) -> None:
        super().__init__(summary.folder)
        self.summary, self.left_out = summary, left_out


def run(
    objects: PathLike | Sequence[str] | None = None,
    trials: int | None = None,
    predictor: str | type | Predictor = "htc-grasp",
    scenario: PathLike | Scenario = "table4",
    *,
    seed: int = 0,
    workers: int | None = None,
    out: PathLike | None = None,
    renderer: str = "auto",
    media: str = "none",
    rerun: PathLike | None = None,
    progress: bool | OnTrial = True,
    shard: str = "1/1",
    executor: str = "process",
    ray_address: str | None = None,
    memory_limit: float | None = None,
    on_error: str = "record",
    weights: PathLike | None = None,
) -> FinishedRun:
    """Try to pick up objects, record every trial, and return the run.

    The same call again goes on where it stopped, as the command does.

    Args:
        objects: ``"all"``, names or categories (comma-separated or as a list), or a folder with a
            ``manifest.json``; by default those that the scenario names, or all.
        trials: spread evenly over the objects; every object once by default.
        predictor: a name from ``grasp-bench predictors``, ``"my_module:MyPredictor"``, a server's
            address, ``"cmd: COMMAND --port {port}"``, a class, or an
            instance. Names, and classes that another process can import, run on worker processes. An
            instance, and a class defined in a script or notebook, is used in this process, one trial
            after the other, without a time limit; a crash in it ends this process. The arguments of an
            instance are not in the record.
        scenario: a shipped scenario's name, the path of a YAML file, or a
            :class:`~grasp_bench.scenario.sections.Scenario`.
        seed: seed of all random numbers.
        workers: number of processes; one for each core by default.
        out: results folder; by default ``results/PREDICTOR-SCENARIO-seedN``. A predictor used in this
            process gets a fresh folder of that name (``-2``, ``-3`` …) each time, because its code may
            have changed; give ``out`` to go on with a run of it.
        renderer: ``auto``, ``raycast`` (needs no graphics library), ``egl`` or ``osmesa``.
        media: ``none``, or pictures of all trials (in clutter of all attempts) and clips of the ``failures``
            or of ``all``, stored in the run's folder; records do not depend on it.
        rerun: a Rerun recording of all trials of this call, ``FILE.rrd`` (extra ``rerun``).
        progress: a bar on standard error (in a notebook a line of text), nothing, or a function called
            with each record and whether it was there before.
        shard: ``"i/N"``: only every N-th trial, from the i-th on; ``grasp-bench merge`` puts the N
            folders together.
        executor: ``"process"`` (this machine) or ``"ray"``.
        ray_address: ``"auto"`` or ``"HOST:PORT"`` of a running Ray cluster; without one, Ray is
            started on this machine.
        memory_limit: most memory of a worker [GiB]; by default its share of 80 % of the machine's.
        weights: a file of weights that ``grasp-bench train`` wrote, instead of ``predictor``; it says itself
            of which network they are.
        on_error: ``"record"`` an error as the outcome of its trial (its traceback goes to ``errors.log`` in
            the run's folder), or ``"raise"`` the first one: an instance's exception as it is, a worker's as
            a PredictorError. Its trial is then done again on resume.

    Raises:
        GraspBenchError: before any trial starts, for anything wrong with the inputs.
    """
    prepare(renderer)
    if trials is not None and not 1 <= trials <= MOST_TRIALS:
        raise GraspBenchError(f"trials must be from 1 to {MOST_TRIALS:,}, not {shown(trials)}")
    check_seed(seed)
    if workers is not None and workers < 0:
        raise GraspBenchError(f"workers must not be negative, not {workers}; 0 takes one for each core")
    if on_error not in ("record", "raise"):
        raise UnknownNameError("choice of on_error", on_error, ("record", "raise"))
    if rerun is not None:
        from grasp_bench.media.rerun_log import import_rerun

        import_rerun()
    chosen = scenario if isinstance(scenario, Scenario) else load_scenario(os.fspath(scenario))
    catalog, names, left_out = objects_for(chosen, objects)
    if chosen.clutter is not None and names != (list(chosen.objects.names) or catalog.names):
        # episodes draw from these
        reasons = {n: chosen.objects.names.get(n, "") for n in names}
        chosen = chosen.model_copy(update={"objects": chosen.objects.model_copy(update={"names": reasons})})
    name, here = named(predictor if weights is None else os.fspath(weights))
    if here is not None and workers not in (None, 1):
        raise PredictorError(
            f"{name} exists in this process only and cannot be sent to {workers or 'all'} "
            "workers; leave workers out, or put its class into a module and name that."
        )
    part = Shard.parse(shard)
    folder = Path(out) if out is not None else default_folder(name, chosen.name, seed, here is not None, part)
    settings = Settings(
        chosen,
        catalog.folder.resolve(),
        name,
        seed,
        resolve_renderer(renderer),
        check_mode(media),
        rerun is not None,
        folder.absolute(),
    )
    jobs = spread(names, len(names) if trials is None else trials, part)
    if not len(jobs):
        raise GraspBenchError(f"Shard {part} of {jobs.total} trials is empty; use fewer shards.")
    limit = None if memory_limit is None else int(memory_limit * 2**30)
    if here is not None and executor != "process":
        raise PredictorError(
            f"{name} exists in this process only and cannot be sent to {executor}; put its "
            "class into a module and name that."
        )
    chosen_executor = None
    if here is None:
        chosen_executor = make_executor(executor, workers or 0, memory_limit=limit, ray_address=ray_address)
    told = cache.first_use() if progress is True else None
    log = None if rerun is None else Path(rerun).absolute()
    early: Any = nullcontext()
    if here is not None:  # it may change the current folder
        folder = folder.absolute()
    elif executor == "process":
        early = early_crew((name,), workers or 0, len(jobs), renderer)
    with told_apart(), early, _reporting(progress, len(jobs)) as on_trial:
        summary = run_trials(settings, jobs, folder, 1, on_trial, here, chosen_executor, on_error == "raise")
    if told is not None:
        print(told, file=sys.stderr)
    if log is not None:
        from grasp_bench.media.rerun_log import join_parts

        join_parts(folder, log)
    return FinishedRun(summary, tuple(left_out))


def load(folder: PathLike) -> Run:
    """Read a run by its folder.

    Raises:
        ResultsError: for a folder that holds no run, or a damaged one.
    """
    return Run(folder)


def load_object(name: str, folder: PathLike | None = None) -> ObjectModel:
    """Read an object by name, its files verified; of the shipped 180 unless ``folder`` holds others.

    Raises:
        UnknownNameError: for an unknown name, with the nearest ones.
        AssetError: for files that are missing or changed.
    """
    return Catalog(None if folder is None else Path(folder)).load(name)


def objects_for(
    scenario: Scenario, objects: PathLike | Sequence[str] | None = None
) -> tuple[Catalog, list[str], list[str]]:
    """Return the catalogue, the names that trials are made of, and those left out, which no grasp fits.

    Args:
        scenario: whose set of objects it is, and whose gripper and arm must manage them.
        objects: as for :func:`run`.

    Raises:
        GraspBenchError: where none is left, or the scenario asks of objects or arm what they cannot do.
    """
    gripper = scenario.robot.loaded.gripper
    asked = list(scenario.objects.names) or "all" if objects is None else objects
    catalog, names = select_objects(asked, gripper, scenario.objects.folder)
    if scenario.objects.graded:
        check_graded(scenario, catalog, names)
    if not known_within_reach(scenario):
        from grasp_bench.planning.reach import check_reach

        check_reach(scenario)
    if scenario.camera.mount == "wrist":
        from grasp_bench.planning.planner import Planner
        from grasp_bench.planning.viewing import view_motions

        view_motions(Planner(scenario))
    names, left_out = graspable(catalog, names, gripper)
    if not names:
        raise GraspBenchError(f"Gripper {gripper.name} can grasp none of {', '.join(left_out[:8])}.")
    return catalog, names, left_out


def select_objects(
    objects: PathLike | Sequence[str], gripper: Gripper = PARALLEL_85, home: str = "objects"
) -> tuple[Catalog, list[str]]:
    """Return the catalogue and the names that ``objects`` means; see :func:`run`.

    Of a folder, objects that are marked as having no grasp that fits the reference gripper are left out;
    which of them fit another ``gripper`` is known when they are prepared for it. Names are looked for in
    ``home``, the scenario's set of objects.

    Raises:
        GraspBenchError: where none is left.
    """
    if not isinstance(objects, (str, os.PathLike)):
        return (catalog := Catalog(folder_of(home))), catalog.select(",".join(objects))
    what = os.fspath(objects)
    if what != "all" and os.path.isdir(what):
        catalog = Catalog(Path(what))
        without = catalog.ungraspable(catalog.names) if is_reference(gripper) else []
        if len(without) == len(catalog.names):
            raise GraspBenchError(
                f"No grasp fits the gripper on any of the {len(without)} objects in {what}."
            )
        return catalog, [n for n in catalog.names if n not in without]
    if "/" in what:
        raise GraspBenchError(f"The folder {what} of --objects does not exist here, in {Path.cwd()}.")
    return (catalog := Catalog(folder_of(home))), catalog.select(what)


def named(predictor: str | type | Predictor) -> tuple[str, Predictor | None]:
    """Return a predictor's name for the record, and the predictor itself if only this process has it."""
    if isinstance(predictor, str):
        return predictor, None
    cls = predictor if isinstance(predictor, type) else type(predictor)
    name = f"{cls.__module__}:{cls.__qualname__}"
    if predictor is cls and cls.__module__ != "__main__" and _importable(cls):
        return name, None
    with Guard(f"{name} could not be made:"):
        made: Any = cls() if predictor is cls else predictor
        if not callable(getattr(made, "predict", None)):
            raise PredictorError(f"{name} has no method predict(image: RgbdImage) -> list[Grasp]")
    return name, made


def _importable(cls: type) -> bool:
    """Return whether a fresh process can find a class by module and name."""
    try:
        return getattr(importlib.import_module(cls.__module__), cls.__qualname__, None) is cls
    except ImportError:
        return False


def default_folder(
    predictor: str, scenario: str, seed: int, fresh: bool = False, shard: Shard = WHOLE
) -> Path:
    """Return ``results/PREDICTOR-SCENARIO-seedN``, with ``-shardIofN`` for one of several shards.

    With ``fresh``, a number is added if need be, so that the folder holds no run.
    """
    plain = re.sub(r"[<>]", "", predictor.removeprefix("__main__:"))
    label = _in_a_name(plain)
    part = f"-shard{shard.index}of{shard.count}" if shard.count > 1 else ""
    folder = Path("results") / f"{label}-{_in_a_name(scenario)}-seed{seed}{part}"
    candidate, number = folder, 1
    while fresh and (candidate / RUN).exists():
        number += 1
        candidate = folder.with_name(f"{folder.name}-{number}")
    return candidate


def _in_a_name(text: str) -> str:
    """Return text as a part of a folder's name, which leads nowhere else."""
    return re.sub(r"[^\w.+=-]+", "-", legible(text)).strip("-.")[:80] or "unnamed"


@contextmanager
def _reporting(progress: bool | OnTrial, total: int) -> Iterator[OnTrial]:
    if callable(progress):
        yield progress
    elif not progress:
        yield lambda record, resumed: None
    else:
        with Progress(total) as bar:
            yield bar.update
