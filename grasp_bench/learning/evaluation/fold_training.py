"""Training of a network for each test set, on all others."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grasp_bench.errors import AssetError
from grasp_bench.learning.data.folds import Folds
from grasp_bench.learning.data.rectangles import Collection
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.sources import mixed_with_real
from grasp_bench.networks.registry import info, input_kind
from grasp_bench.networks.store import WeightsFile
from grasp_bench.runs.evaluation import FoldTraining


@dataclass(frozen=True)
class Training:
    """How a model is trained for each fold, on the other folds.

    Attributes:
        settings: those of every run, apart from network and first weights.
        init: weights to begin with; None for random ones.
        synthetic: folders of generated scenes mixed in.
        real_share: share of the real images in what is seen, if others are mixed in.
        out: folder that holds a run for each fold. Finished folds there are not trained again.
    """

    settings: TrainConfig
    init: Path | None
    synthetic: list[Path]
    real_share: float
    out: Path


def train_fold(
    network: str, training: Training, collection: Collection, folds: Folds, fold: int
) -> tuple[Path, FoldTraining]:
    """Train on all but one fold, unless that is done already; the weights, and facts on the training."""
    from grasp_bench.learning.training.loop import shown, train
    from grasp_bench.networks.weights import save

    settings = training.settings
    out = training.out / f"fold-{fold + 1}-of-{len(folds.test)}"
    collection.require(input_kind(network, settings.input), network)
    scenes = mixed_with_real(
        training.synthetic, collection, folds.train(fold), training.real_share, info(network).crop
    )
    facts = FoldTraining(
        steps=settings.steps,
        batch=settings.batch,
        lr=settings.lr,
        seed=settings.seed,
        begun_with=WeightsFile(training.init).described() if training.init else None,
        real_images=len(folds.train(fold)),
        real_share=training.real_share if training.synthetic else 1.0,
        synthetic=[f.name for f in training.synthetic],
        scenes=len(scenes.train),
    )
    config = settings.model_copy(update={"network": network, "init": facts.begun_with})
    path = out / f"{network}.safetensors"
    try:
        trained = train(config, scenes, out, None, training.init)
    except AssetError as error:  # of a run with other settings
        raise AssetError(str(error).replace("--out", "--runs")) from error
    save(
        trained.network,
        path,
        {
            "network": network,
            "input": shown(config),
            "trained": facts.model_dump(),
            "left_out": [collection.entries[i].name for i in folds.test[fold]],
        },
    )
    return path, facts
