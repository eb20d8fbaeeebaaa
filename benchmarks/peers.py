"""What a trial costs beside its bare physics, and beside a pick in another package.

    python benchmarks/peers.py [--trials 18] [--peer-python PATH]

Trials of one process with one thread: ``oracle`` (no network) and ``htc-grasp``, and the same steps by bare
``mj_step``, which no harness can undercut. With ``--peer-python``, a scripted pick of robosuite's ``Lift`` by
its Panda, in an environment of its own, because it needs another MuJoCo:

    python -m venv /tmp/peer && /tmp/peer/bin/pip install robosuite==1.5.2 mujoco==3.5.0

Processor seconds are counted, so load from elsewhere matters less. The packages do not simulate the same:
the second table says what each does for its seconds. Nothing is written outside of a temporary folder.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import cv2
import mujoco
import numpy as np
from physics_share import Recorder  # first: it sets the number of threads before NumPy is imported
from rich.console import Console
from rich.table import Table

from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors import load_predictor
from grasp_bench.runs.jobs import spread
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scene import world as world_module
from grasp_bench.scene.world import ROLLOUT
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

PEER = Path(__file__).with_name("peers_robosuite.py")


def ours(predictor: str, trials: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Figures of our trials, and of their steps alone."""
    scenario, catalog = load_scenario("table4"), Catalog()
    names = catalog.names[:: max(1, len(catalog.names) // trials)]
    cell, asked = Workcell(scenario), load_predictor(predictor)
    recorder = Recorder()
    seconds = bare = 0.0
    steps = lifted = 0
    contacts: list[int] = []
    for warm in (True, False):
        world_module.mujoco = mujoco if warm else recorder
        world_module.ROLLOUT = ROLLOUT if warm else recorder
        for job in spread(names, 2 if warm else trials):
            model = catalog.load(job.object)
            began = time.process_time()
            done = run_trial(cell, model, asked, trial=job.trial, attempt=job.attempt)
            if warm:
                continue
            seconds += time.process_time() - began
            lifted += done.record.outcome is Outcome.SUCCESS
            began = time.process_time()
            steps += recorder.replay()[1]
            bare += time.process_time() - began
            if done.world is not None:
                contacts.append(done.world.data.ncon)
    world_module.mujoco, world_module.ROLLOUT = mujoco, ROLLOUT
    step = scenario.physics.timestep
    common = {
        "trials": trials,
        "lifted": lifted,
        "steps": steps / trials,
        "simulated": steps / trials * step,
        "timestep": step,
        "contacts": float(np.mean(contacts)),
        "mujoco": mujoco.__version__,
    }
    return (
        common | {"name": f"grasp-bench, {predictor}", "seconds": seconds / trials},
        common | {"name": f"bare mj_step, steps of {predictor}", "seconds": bare / trials},
    )


def robosuite(python: str, trials: int, image: bool) -> dict[str, Any]:
    """Figures of the peer's picks, made by its own interpreter in an empty folder."""
    with tempfile.TemporaryDirectory() as folder:
        command = [python, str(PEER), str(trials), *(["--image"] if image else [])]
        environment = os.environ | {
            "NUMBA_CACHE_DIR": folder,
            "TMPDIR": folder,
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        environment.pop("PYTHONPATH", None)
        done = subprocess.run(
            command, capture_output=True, text=True, cwd=folder, env=environment, check=False
        )
    if done.returncode:
        raise SystemExit(f"The peer does not work in {python}:\n{done.stderr.strip()[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])


SIMULATED = (
    ("objects", "180 household objects of up to 32 convex pieces", "one cube of 4 cm"),
    (
        "arm",
        "six joints, position servos with velocity lead",
        "seven joints, torques of an operational-space law",
    ),
    (
        "motion",
        "IK (mink) of a planned path, spline, minimum jerk; 250 Hz",
        "proportional steps to the cube; 20 Hz",
    ),
    (
        "image",
        "640 × 480 depth and colour, ray cast",
        "none, or 84 × 84 depth and colour by OpenGL (--image)",
    ),
    ("noise of the sensor", "yes", "no"),
    (
        "contact",
        "elliptic cones, no-slip iterations while held",
        "pyramidal or elliptic as shipped, no no-slip",
    ),
    ("chooses the grasp from", "the noisy image (oracle: the truth)", "the truth"),
    ("held after lifting", "carried and held, judged by slip", "lifted 4 cm above the table"),
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=18)
    parser.add_argument("--peer-python", help="interpreter of an environment that has robosuite")
    parser.add_argument("--image", action="store_true", help="the peer takes a picture of every scene, too")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    rows = [row for name in ("oracle", "htc-grasp") for row in ours(name, args.trials)]
    if args.peer_python:
        rows.append(robosuite(args.peer_python, args.trials, args.image))
    table = Table(title=f"{args.trials} trials each, one process, one thread; processor seconds")
    for column in (
        "",
        "trials/s/core",
        "ms a trial",
        "simulated s",
        "steps",
        "dt ms",
        "µs a step",
        "× real time",
    ):
        table.add_column(column, justify="right" if column else "left")
    table.add_column("contacts at the end", justify="right")
    table.add_column("lifted", justify="right")
    table.add_column("MuJoCo", justify="right")
    for row in rows:
        seconds, steps = row["seconds"], row["steps"]
        table.add_row(
            row["name"],
            f"{1 / seconds:.2f}",
            f"{1000 * seconds:.0f}",
            f"{row['simulated']:.2f}",
            f"{steps:.0f}",
            f"{1000 * row['timestep']:g}",
            f"{1e6 * seconds / steps:.0f}",
            f"{row['simulated'] / seconds:.1f}",
            f"{row['contacts']:.0f}",
            f"{row['lifted']}/{row['trials']}",
            row["mujoco"],
        )
    console = Console(width=170)
    console.print(table)
    does = Table(title="What each does for its seconds")
    for column in ("", "grasp-bench, table4", "robosuite, Lift"):
        does.add_column(column)
    for line in SIMULATED:
        does.add_row(*line)
    console.print(does)
    if args.peer_python:
        ours_, peer = rows[0], rows[-1]
        trial, second = (
            ours_["seconds"] / peer["seconds"],
            (ours_["simulated"] / ours_["seconds"] / (peer["simulated"] / peer["seconds"])),
        )
        console.print(
            f"A trial with oracle takes {trial:.2f} of the peer's processor time; a processor second "
            f"simulates {second:.2f} times as many seconds as with the peer."
        )
    else:
        console.print(
            "No peer was measured: --peer-python names the interpreter of an environment that has one."
        )


if __name__ == "__main__":
    main()
