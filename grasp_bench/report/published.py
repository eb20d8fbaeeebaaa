"""What the authors of each network published of it, beside what was measured here, and why they differ.

Published figures are of networks that were trained on the data set they are tested on; the shipped ones saw
synthetic scenes only. Sources of the figures: the networks' own papers, and for those not read the comparison
tables of GR-ConvNet v2 (Kumra, Joshi, Sahin, Sensors 22:6208, 2022, section 6).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from grasp_bench.report.tables import TextTable
from grasp_bench.runs.evaluation import Evaluation

FAR = 5.0
"""Points of difference from which on a reason is owed."""


@dataclass(frozen=True)
class Published:
    """What a network's authors, or who measured it first, published of it.

    Attributes:
        network: its name in this package.
        source: where.
        cornell, jacquard: accuracy [%] as printed; of Cornell object-wise. None where none was published.
        why: what makes ours another question besides :data:`NOTE`; empty for nothing.
    """

    network: str
    source: str
    cornell: float | None
    jacquard: float | None = None
    why: str = ""


FROM_PHOTOGRAPHS = (
    "published with a trunk that had learnt from a million photographs, here from random weights"
)
CUT_OFF = "cut off by the clock"
LATER = "measured by others, later"
PUBLISHED = (
    Published(
        "lenz-sae",
        "RSS 2013, IJRR 34(4–5)",
        75.6,
        why="judges a rectangle by whether it held in physics, not by whether people drew it",
    ),
    Published("redmon-multigrasp", "ICRA 2015", 87.1, why=FROM_PHOTOGRAPHS),
    Published("redmon-direct", "ICRA 2015", 84.9, why=FROM_PHOTOGRAPHS),
    Published("kumra-resnet50x2", "IROS 2017", 88.96, why=FROM_PHOTOGRAPHS),
    Published("kumra-resnet50", "IROS 2017", 87.72, why=FROM_PHOTOGRAPHS),
    Published("chu-resnet50", "RA-L 3(4), 2018", 96.1, why=FROM_PHOTOGRAPHS),
    Published("asif-graspnet", "IJCAI 2018", 90.6, why="a reconstruction after its abstract"),
    Published("gg-cnn", LATER, 69.0),
    Published("gg-cnn2", "IJRR 39(2–3), 2020", None, 84.0),
    Published("fcgn", "IROS 2018", 96.61, 92.8, why=FROM_PHOTOGRAPHS),
    Published("roi-gd", "IROS 2019", 93.5, 93.6, why=FROM_PHOTOGRAPHS),
    Published("se-resunet", "RA-L 7(2), 2022", 97.1, 95.7),
    Published("gr-convnet", "IROS 2020", 96.6, 94.6),
    Published(
        "tf-grasp", "RA-L 7(3), 2022", 96.7, 94.6, why="its authors count the better of two grasps an image"
    ),
    Published("htc-grasp", "Electronics 12(6), 2023", 96.9, 95.8),
)
"""GQ-CNN has no accuracy by rectangles, and the figures of Laili's and Wu's networks are not known."""

SYNTHETIC = "learnt from synthetic scenes alone"
COLOUR = "colour alone, four fifths of the images, and little training"
NOTE = (
    "Published: as printed, on Cornell object-wise, by networks trained on the data set they are tested on. "
    "Zero-shot: the shipped weights, which saw synthetic scenes and no real image, by the strict protocol. "
    "Per fold: trained on the images of other objects, in colour alone, strict. Points: ours that is nearer "
    "in training (per fold, else zero-shot) less published. No rectangle that a person drew was ever shown "
    "to the zero-shot networks, which is the first reason for all their rows."
)


def published_table(results: Sequence[Evaluation], cut_off: Collection[str] = ()) -> TextTable:
    """Return the table of what was published of each network beside what was measured here.

    Args:
        results: evaluations; those of other networks, splits and protocols are passed over.
        cut_off: networks whose training was ended by the clock.
    """
    head = ("Network", "Published in", "Cornell", "Zero-shot", "Per fold", "Points")
    head += ("Jacquard", "Zero-shot", "Points", f"Why, where more than {FAR:g} apart")
    rows = [_row(known, results, known.network in cut_off) for known in PUBLISHED]
    return TextTable("Published accuracy, and ours", head, rows, note=NOTE, numbers=range(2, 9))


def _row(known: Published, results: Sequence[Evaluation], cut_off: bool) -> list[str]:
    strict = [r for r in results if r.predictor == known.network and r.protocol == "strict"]
    shipped = [r for r in strict if r.weights and not r.weights.saw_real_images]
    cornell = next((r for r in shipped if r.dataset == "cornell"), None)
    jacquard = next((r for r in shipped if r.dataset == "jacquard"), None)
    # Of folds those in colour: Cornell's few images with depth have no object ids to split by.
    trained = [r for r in strict if r.trained and r.object_ids and r.split == "object"]
    of_cornell = (r for r in trained if r.dataset == "cornell")
    fold = max(of_cornell, key=lambda r: r.images, default=None)
    reasons: list[str] = []

    def points(printed: float | None, ours: Evaluation | None) -> str:
        if printed is None or ours is None:
            return ""
        apart = 100 * ours.rate - printed
        if abs(apart) > FAR:
            reasons.append(COLOUR if ours.trained else SYNTHETIC)
        return f"{apart:+.1f}"

    cells = [_printed(known.cornell), _told(cornell), _told(fold), points(known.cornell, fold or cornell)]
    cells += [_printed(known.jacquard), _told(jacquard), points(known.jacquard, jacquard)]
    if reasons:
        reasons += [known.why] if known.why else []
        reasons += [CUT_OFF] if cut_off else []
    elif not shipped:
        reasons.append("no weights are shipped")
    return [known.network, known.source, *cells, "; ".join(dict.fromkeys(reasons))]


def _printed(percent: float | None) -> str:
    return "" if percent is None else f"{percent:g}%"


def _told(result: Evaluation | None) -> str:
    return f"{result.correct}/{result.images} = {result.rate:.1%}" if result else ""
