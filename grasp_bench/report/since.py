"""What was published since the HTC-Grasp paper, or was overlooked by its tables, with sources.

Figures are their authors', each on a split of its own; nothing of them was measured here. Cornell has been
full since 2018: one of the 88 or 89 images of a tenth is 1.1 points.
"""

from __future__ import annotations

from dataclasses import dataclass

from grasp_bench.report.tables import TextTable


@dataclass(frozen=True)
class Later:
    """A detector that is not in the paper's tables.

    Attributes:
        name, year: what it is called, and when it was published; None where its source does not say.
        cornell: accuracy image-wise / object-wise [%], as printed.
        jacquard: accuracy [%], as printed.
        parameters, milliseconds: as printed; empty where not known.
        source: where the figures are from.
        read: 'paper' where its text, abstract or a later comparison was read for this table, 'memory' where
            not.
        here: name of the network in this package; empty where it has none.
    """

    name: str
    year: int | None
    cornell: str
    jacquard: str
    source: str
    parameters: str = ""
    milliseconds: str = ""
    read: str = "paper"
    here: str = ""


SINCE = (
    Later("REM (Park et al.)", 2018, "99.2 / 98.6", "", "its abstract", milliseconds="20"),
    Later("DD-Net", 2021, "97.2 / 96.1", "97.0", "its abstract"),
    Later("SE-ResUNet", 2022, "98.2 / 97.1", "95.7", "RA-L 7(2):5238", "16.4 M", "25", here="se-resunet"),
    Later("GR-ConvNet v2", 2022, "98.8 / 97.7", "95.1", "Sensors 22:6208", "1.9 M", "20"),
    Later("Fully matching multi-scale", 2022, "98.87 / 97.83", "", "CMES 133(2):48964", milliseconds="45"),
    Later("SKGNet", 2023, "99.1 / 98.4", "95.9", "T-ASE 20(4)", "3.9 M", read="memory", here="skgnet"),
    Later("Self-attention and CNN", 2023, "97.7", "", "Appl. Sci. 13:9655"),
    Later("Sparse-GRConvNet", 2023, "97.75", "85.8", "its abstract: a tenth of GR-ConvNet's weights"),
    Later("RAGT", 2023, "", "", "arXiv 2306.10265, on 31,500 images of its own", "MobileViT-S trunk"),
    Later("FAGD-Net", 2024, "98.9", "96.5", "Appl. Sci. 14:5097"),
    Later("SGNet", 2024, "99.4", "93.4", "preprints 202410.0076", "1 M", "12.5"),
    Later("HMT-Grasp", 2024, "above TF-Grasp", "", "arXiv 2410.03522"),
    Later("DSNet, RGB-D", None, "98.31", "", "D2TriPO-DETR's readme"),
    Later("Yang et al., RGB", None, "98.74", "", "D2TriPO-DETR's readme"),
    Later("D2TriPO-DETR, RGB", 2025, "98.87", "", "its repository's readme"),
    Later("GR-AttNet", 2025, "98.1", "94.9", "PLoS One e0337599", "2.8 M printed, 1.3 M in its code", "148"),
    Later("SATNet", 2025, "97.8", "", "its abstract", "0.27 M", "16.3"),
    Later("GraspSAM", 2025, "", "reported", "arXiv 2409.12521", "EfficientSAM or MobileSAM"),
)

NOTE = (
    "Authors' own figures, on splits of their own; not measured here. Cornell cannot tell them apart: with a "
    "tenth of it as test, one image is 1.1 points and the 95 % interval of 98 % some ±3. On Jacquard DD-Net "
    "and FAGD-Net are above HTC-Grasp's 95.8 %. Detectors that are told in words what to grasp (LGD, "
    "GraspMamba, MapleGrasp) answer another question and are left out. A network with a name in the last "
    "column can be run here."
)


def since_table() -> TextTable:
    """Return the table of what is not in the paper's tables."""
    rows = [
        [
            later.name if later.year is None else f"{later.name} ({later.year})",
            later.cornell,
            later.jacquard,
            later.parameters,
            later.milliseconds,
            later.source + (", not re-read" if later.read == "memory" else ""),
            later.here,
        ]
        for later in SINCE
    ]
    head = ("Method", "Cornell [%]", "Jacquard [%]", "Parameters", "ms", "Source", "Here")
    return TextTable(
        "Since then, and beside", head, rows, note=NOTE, numbers=(4,), paper=frozenset(range(len(rows)))
    )
