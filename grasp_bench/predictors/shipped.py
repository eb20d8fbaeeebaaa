"""The predictors that are shipped: registered networks with their weights, and controls."""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any, ClassVar, Literal

from grasp_bench.errors import AssetError
from grasp_bench.networks.registry import all_weights
from grasp_bench.networks.spec import Network, Weights
from grasp_bench.networks.store import WeightsFile, shipped_file, stored_input
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.predictors.sources import resolve

SPATIAL = "spatial_controls"
"""Module of the controls of grasps in six degrees of freedom."""
NETWORK_PREDICTOR = "grasp_bench.predictors.network:NetworkPredictor"
TTA = "-tta"
"""End of the name of a network that is asked with test-time augmentation."""


@dataclass(frozen=True)
class Shipped:
    """A shipped predictor's name.

    Attributes:
        name: what users call it.
        kind: ``network`` or ``control``.
        summary: one line for listings.
        path: ``module:Class``, imported when first used.
        network, trained: the registered network, and which of its weights; None for a control.
        tta: whether the network is asked with test-time augmentation.
    """

    name: str
    kind: Literal["network", "control"]
    summary: str
    path: str
    apart: ClassVar[None] = None  # it is this package's own code
    network: Network | None = None
    trained: Weights | None = None
    tta: bool = False

    @property
    def weights(self) -> WeightsFile | None:
        """The file of the weights it needs, if any."""
        if self.network is None or self.trained is None:
            return None
        return shipped_file(self.trained.name, self.network.name)

    @property
    def group(self) -> str:
        """Heading under which it is listed."""
        return "controls" if self.network is None else self.network.group

    @property
    def available(self) -> bool:
        """Whether the weights it needs are there."""
        return self.weights is None or self.weights.present

    def load(self) -> Predictor:
        """Make the predictor.

        Raises:
            AssetError: for weights that are missing or altered.
        """
        maker = resolve(self.path)
        if self.network is None or self.weights is None:
            return maker()
        return maker(self.network.name, self.weights.path, tta=self.tta)

    def facts(self, predictor: object) -> dict[str, Any]:
        """Return what identifies it: the version of grasp-bench, and its weights."""
        software = {"software": f"grasp-bench {version('grasp-bench')}"}
        if self.weights is None:
            return software
        self.weights.require()
        return software | {"files": {self.weights.name: self.weights.digest}}

    def details(self) -> dict[str, Any]:
        """Return what is known of a network and of its training, None where it is not known; else empty."""
        if self.network is None or self.trained is None or self.weights is None:
            return {}
        try:
            stored = self.weights.metadata()
        except AssetError:  # missing or damaged: the digest says so
            stored = {}
        kind = stored_input(stored) or self.network.kind
        return {
            "parameters": stored.get("parameters", self.network.parameters.get(kind)),
            "input": kind,
            "crop": self.network.crop,
            "weights": {"file": self.weights.name, "sha256": self.weights.digest},
            "trained_on": stored.get("data"),
            "steps": stored.get("steps"),
            "seconds": stored.get("seconds"),
            "reference": self.network.reference,
            "paper_rows": {f"Table {table}": row for table, row in self.trained.rows.items()},
        }


def averaged(name: str) -> Shipped:
    """Return shipped weights, asked with test-time augmentation; that is no row of the paper's."""
    network, weights = all_weights()[name]
    summary = f"{name} asked four times, of turned and mirrored copies: slower, more often right"
    plain = replace(weights, rows={})
    return Shipped(f"{name}{TTA}", "network", summary, NETWORK_PREDICTOR, network, plain, tta=True)


def _control(name: str, summary: str, module: str = "controls") -> Shipped:
    maker = name.capitalize().replace("-", "")
    return Shipped(name, "control", summary, f"grasp_bench.predictors.{module}:{maker}")


SHIPPED: dict[str, Shipped] = {
    shipped.name: shipped
    for shipped in (
        *(
            Shipped(weights.name, "network", weights.summary, NETWORK_PREDICTOR, network, weights)
            for network, weights in all_weights().values()
        ),
        averaged("htc-grasp"),
        _control("oracle", "upper bound: reference grasps of the true mesh, tried out beforehand"),
        _control("oracle-6dof", "upper bound from any direction: as oracle, not only from above", SPATIAL),
        _control("antipodal-6dof", "hands pushed into the point cloud, after Grasp Pose Detection", SPATIAL),
        _control("antipodal", "opposite depth edges, after Dex-Net's sampling"),
        _control("centroid", "middle and shorter axis of the depth blob"),
        _control("random", "a random place and direction on the object"),
        _control("random-10", "ten of these: what the planner alone can do"),
        _control("displaced", "the oracle's grasp 0.2 m beside: must fail"),
    )
}
