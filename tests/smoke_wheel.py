"""Install the built wheel into an empty environment outside the checkout, and use it.

``python tests/smoke_wheel.py dist``: the objects, the arm, the scenarios and the weights must
all have travelled in the wheel, and the sdist must hold what a wheel is built from.
"""

import json
import subprocess
import sys
import tarfile
import tempfile
import venv
from pathlib import Path


def main(dist: Path) -> None:
    wheel, sdist = next(dist.glob("*.whl")), next(dist.glob("*.tar.gz"))
    with tarfile.open(sdist) as archive:
        names = archive.getnames()
    for needed in ("pyproject.toml", "grasp_bench/trial.py", "assets/ec66/ec66.xml", "scenarios/table4.yaml"):
        assert any(n.endswith(needed) for n in names), f"{needed} is missing from {sdist.name}"
    constraints = Path(__file__).parents[1] / "constraints.txt"
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        venv.create(home / "venv", with_pip=True)
        python = home / "venv" / "bin" / "python"
        subprocess.run([python, "-m", "pip", "install", "-q", "-c", constraints, wheel.resolve()], check=True,
                       cwd=home)
        command = [home / "venv" / "bin" / "grasp-bench"]
        subprocess.run([*command, "objects", "verify"], check=True, cwd=home)
        subprocess.run([*command, "run", "--trials", "3", "--objects", "mug", "--out", "out", "--quiet"],
                       check=True, cwd=home)
        report = subprocess.run([*command, "report", "out", "--format", "json"], check=True, cwd=home,
                                capture_output=True, text=True).stdout
        run = json.loads(report)["runs"][0]
        assert run["trials"] == 3, run
    print(f"{wheel.name} ({wheel.stat().st_size / 1e6:.1f} MB) works in an empty environment: "
          f"{run['successes']}/3 with {run['predictor']}.")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
