"""Tables 1 to 4 of the HTC-Grasp paper as printed (Electronics 12(6), 2023, 1505).

No counts or test images are printed in Tables 1 to 3, so that no intervals can be given for their rows. A
network that stands for a row names it in its registration, by the table's number and the row's ``method``.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperRow:
    """A row of the paper's Tables 1 and 2.

    Attributes:
        authors, method, input: as printed.
        image_wise, object_wise: accuracy [%]; None where not printed.
        milliseconds: time for one image, each on its authors' hardware.
    """

    authors: str
    method: str
    input: str
    image_wise: float | None
    object_wise: float | None = None
    milliseconds: float | None = None


TABLE_1 = (
    PaperRow("Lenz", "SAE", "RGB-D", 73.9, 75.6, 1350),
    PaperRow("Redmon", "AlexNet", "RGB-D", 88, 87.1, 76),
    PaperRow("Kumra", "ResNet-50x2", "RGB-D", 89.2, 88.9, 103),
    PaperRow("Morrison", "GG-CNN", "D", 73, 69, 19),
    PaperRow("Chu", "ResNet-50", "RGB-D", 96, 96.1, 120),
    PaperRow("Asif", "GraspNet", "RGB-D", 90.2, 90.6, 24),
    PaperRow("Kumra", "GR-CNN", "RGB-D", 97.7, 96.6, 20),
    PaperRow("Wang", "TF-Grasp", "RGB-D", 97.99, 96.7, 41.6),
    PaperRow("HTC-Grasp authors", "HTC-Grasp", "RGB-D", 98.3, 96.9, 5.4),
)
"""Accuracy on Cornell."""

TABLE_2 = (
    PaperRow("Morrison", "GG-CNN2", "D", 84),
    PaperRow("Kumra", "GR-CNN", "RGB-D", 94.6),
    PaperRow("Wang", "TF-Grasp", "RGB-D", 94.6),
    PaperRow("HTC-Grasp authors", "HTC-Grasp", "RGB-D", 95.8),
)
"""Accuracy on Jacquard; the split is not printed, 90 % of the images were trained on."""


@dataclass(frozen=True)
class AblationRow:
    """A row of the paper's Table 3, with the accuracy [%] on Cornell and Jacquard."""

    external_attention: bool
    channel_attention: bool
    cornell: float
    jacquard: float

    @property
    def method(self) -> str:
        """The switches with a check mark: external attention, channel attention."""
        return " + ".join(["EA"] * self.external_attention + ["CA"] * self.channel_attention)


TABLE_3 = (
    AblationRow(True, False, 97.2, 94.2),
    AblationRow(False, True, 97.6, 94.7),
    AblationRow(True, True, 98.3, 95.8),
)

TABLES = {"cornell": TABLE_1, "jacquard": TABLE_2}
MISPRINTS = {
    "cornell": "As printed, Lenz's 1350 ms is a tenth of the original's 13.5 s an image, a slip handed on "
    "from table to table. 98.3 % is no k/88 or k/89, which a tenth of 885 images would give: 174/177, or a "
    "mean of folds. Redmon's row has MultiGrasp's accuracy, and the RGB-D of Redmon and Chu is three "
    "channels, depth instead of blue. GG-CNN's row was measured later by others. TF-Grasp's released "
    "validation counts an image as right when either of two grasps matches a label.",
    "jacquard": "The printed table does not say how the images were split.",
}
"""What is wrong or left out in the printed Tables 1 and 2, or easily misread."""
MISPRINTS_3 = (
    "The printed table's caption names one data set and its rows are of two, with the check marks of "
    "Jacquard's rows out of line; the order of Cornell's is taken for both."
)


@dataclass(frozen=True)
class RobotRow:
    """A row of the paper's Table 4: grasps by a real robot, with the printed rate [%]."""

    authors: str
    system: str
    successes: int
    trials: int
    printed_rate: float


TABLE_4 = (
    RobotRow("Lenz", "SAE", 89, 100, 89.0),
    RobotRow("Morrison", "GG-CNN", 110, 120, 92.0),  # 110/120 is 91.7 %; the paper prints 92.0 %
    RobotRow("Chu", "ResNet-50", 89, 100, 89.0),
    RobotRow("Wang", "TF-Grasp", 152, 165, 92.1),
    RobotRow("HTC-Grasp authors", "HTC-Grasp", 168, 180, 93.3),
)
