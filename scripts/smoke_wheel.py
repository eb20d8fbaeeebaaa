"""Install the built wheel into an empty environment outside the checkout, and use it.

``python scripts/smoke_wheel.py dist``: objects, arm, scenarios and weights must all have travelled in the
wheel, nothing may come from the checkout, and five trials must run and be reported. ``python -m build``
makes the wheel from the sdist, so the sdist is complete if the wheel is. Then grasp-bench-rivals is installed
beside it, and a network whose weights came with it does a trial.
"""

import json
import os
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

LARGEST = {"wheel": 40e6, "sdist": 55e6, "rivals": 150e6}
"""Bytes; the objects take 5 MB packed, each variant of HTC-Grasp 4.5 MB, its rivals' weights 12 MB."""
NEEDED = (
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "constraints.txt",
    "grasp_bench/trials/attempt.py",
    "assets/ec66/ec66.xml",
    "assets/objects/manifest.json",
    "scenarios/table4.yaml",
    "tests/conftest.py",
    "examples/01_my_predictor.py",
    "docs/definition.md",
)


def check_contents(wheel: Path, sdist: Path) -> None:
    """What must be inside, what must not, and how large it may be."""
    with tarfile.open(sdist) as archive:
        names = [n.partition("/")[2] for n in archive.getnames()]
    for needed in NEEDED:
        assert needed in names, f"{needed} is missing from {sdist.name}"
    with zipfile.ZipFile(wheel) as archive:
        inside = archive.namelist()
    foreign = [n for n in inside if n.split("/")[0] != "grasp_bench" and ".dist-info/" not in n]
    assert not foreign, f"{wheel.name} would install {foreign[:3]} beside the package"
    assert "grasp_bench/py.typed" in inside
    for path, kind in ((wheel, "wheel"), (sdist, "sdist")):
        size = path.stat().st_size
        assert size < LARGEST[kind], f"{path.name} has {size / 1e6:.0f} MB: too much for a {kind}"


def check_rivals(wheel: Path) -> list[str]:
    """Return the names of the weights in the wheel of grasp-bench-rivals."""
    size = wheel.stat().st_size
    assert size < LARGEST["rivals"], f"{wheel.name} has {size / 1e6:.0f} MB"
    with zipfile.ZipFile(wheel) as archive:
        inside = [n for n in archive.namelist() if ".dist-info/" not in n]
        listed = json.loads(archive.read("grasp_bench_rivals/weights/manifest.json"))
    foreign = [n for n in inside if not n.startswith("grasp_bench_rivals/")]
    assert not foreign, f"{wheel.name} would install {foreign[:3]}"
    weights = sorted(Path(n).name for n in inside if n.endswith(".safetensors"))
    assert weights == sorted(listed), f"{wheel.name} holds {weights}, its manifest lists {sorted(listed)}"
    return [Path(n).stem for n in weights]


def main(dist: Path) -> None:
    wheel, sdist = next(dist.glob("grasp_bench-*.whl")), next(dist.glob("*.tar.gz"))
    rivals = next(dist.glob("grasp_bench_rivals-*.whl"))
    large = check_rivals(rivals)
    check_contents(wheel, sdist)
    constraints = Path(__file__).parents[1] / "constraints.txt"
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        venv.create(home / "venv", with_pip=True)
        python = home / "venv" / "bin" / "python"

        def use(*command: str | Path) -> str:
            return subprocess.run(
                command, check=True, cwd=home, env=environment, stdout=subprocess.PIPE, text=True
            ).stdout

        use(python, "-m", "pip", "install", "-q", "-c", constraints, wheel.resolve())
        origin = use(python, "-c", "import grasp_bench; print(grasp_bench.__file__)")
        assert str(home) in origin, f"the package came from {origin.strip()}"
        command = home / "venv" / "bin" / "grasp-bench"
        assert use(command, "--version").split()[1] == wheel.name.split("-")[1]
        assert "229 of 229 objects are as the manifest says" in use(command, "objects", "verify")
        use(command, "run", "--trials", "5", "--out", "out", "--quiet", "--max-errors", "5")
        run = json.loads(use(command, "report", "out", "--format", "json"))["runs"][0]
        assert (run["trials"], run["predictor"]) == (5, "htc-grasp"), run
        if set(run["outcomes"]) & {"unstable", "timeout", "error"}:
            raise SystemExit(
                "Trials failed for no fault of the predictor:\n" + (home / "out" / "trials.jsonl").read_text()
            )
        use(python, "-m", "pip", "install", "-q", "--no-deps", rivals.resolve())
        where = use(python, "-c", "from grasp_bench.system.paths import rivals_dirs; print(*rivals_dirs())")
        assert str(home) in where, f"the rivals' weights are looked for in {where.strip()}"
        for name in large[:1]:
            use(command, "run", "--predictor", name, "--trials", "1", "--out", "rival", "--quiet")
    sizes = ", ".join(f"{p.name} ({p.stat().st_size / 1e6:.1f} MB)" for p in (wheel, sdist, rivals))
    print(f"{sizes}: works in an empty environment, {run['successes']}/5 with {run['predictor']}.")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
