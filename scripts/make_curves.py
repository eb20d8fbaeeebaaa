"""Draw the learning curves of ``results/training/*.json`` for the documentation.

``python scripts/make_curves.py``: each is the ``training.json`` that ``grasp-bench train`` leaves in its
folder, named after the network. Writes ``docs/images/learning-{pflop,minutes,steps}.svg``.
"""

from pathlib import Path
from typing import get_args

from grasp_bench.studies.curve_chart import Cost, Curve, as_svg

ROOT = Path(__file__).parents[1]


def main() -> None:
    curves = [Curve.read(path) for path in sorted((ROOT / "results" / "training").glob("*.json"))]
    for cost in get_args(Cost):
        path = ROOT / "docs" / "images" / f"learning-{cost.lower()}.svg"
        path.write_text(as_svg(curves, cost), encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
