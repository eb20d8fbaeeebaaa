"""Results of ``grasp-bench evaluate``: how often a predictor's best grasp is right on labelled images."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    JsonValue,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
)

from grasp_bench.errors import ResultsError
from grasp_bench.runs.schema import strict_json
from grasp_bench.system.files import read_text
from grasp_bench.system.integrity import write_whole

Split = Literal["image", "object"]
Protocol = Literal["strict", "legacy"]
DatasetName = Literal["cornell", "jacquard"]
AnyDataset = Literal[DatasetName, "synthetic"]
Verdict = Literal["correct", "wrong_angle", "elsewhere", "none", "error"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="allow")


class _Said(_Part):
    """Facts of which any may be missing; those that are missing are not written."""

    @model_serializer(mode="wrap")
    def _without_missing(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {k: v for k, v in write(self).items() if k in self.model_fields_set}


class WeightsData(_Said):
    """Data that weights were trained on.

    Attributes:
        fingerprint: digest of the scenes.
        folders, real: names of all folders, and of those with real images.
        train, val: number of scenes to train and to validate on.
    """

    fingerprint: str | None = None
    folders: list[str] = []
    real: list[str] = []
    train: int | None = None
    val: int | None = None


class Weights(_Said):
    """What a network's weights say of their training.

    Attributes:
        network, parameters: name of the network, and the number of its parameters.
        input: kind and side [px], such as ``rgbd 224``.
        steps, seed, begun_with, data, seconds: what a training by ``grasp-bench train`` notes.
        trained: what a training for one fold notes, as :class:`FoldTraining`.
    """

    network: str | None = None
    parameters: int | None = None
    input: str | None = None
    steps: int | None = None
    seed: int | None = None
    begun_with: str | None = None
    data: WeightsData | None = None
    trained: dict[str, JsonValue] | None = None
    seconds: int | float | None = None

    @property
    def saw_real_images(self) -> bool:
        """Whether images of Cornell or Jacquard were among the data."""
        return self.trained is not None or bool(self.data and self.data.real)


class FoldTraining(_Part):
    """A training for one fold, on the images of the others.

    Attributes:
        begun_with: name and SHA-256 of the first weights; None for random ones.
        real_images, real_share: number of images of the other folds, and their share of what was seen.
        synthetic: names of the folders of generated scenes mixed in.
        scenes: images and generated scenes in all.
    """

    steps: int
    batch: int
    lr: float
    seed: int
    begun_with: str | None
    real_images: int
    real_share: float
    synthetic: list[str]
    scenes: int


class Fold(_Part):
    """One test set: its number from 1, how many images are right of how many, and the training for it."""

    fold: int
    correct: int
    images: int
    trained: FoldTraining | None


class Latency(_Part):
    """Milliseconds from image to grasps: median and 95th percentile on the clock, median on the processor."""

    median: float
    p95: float
    cpu_median: float


class Machine(_Part):
    """The machine computed on: processor, threads, precision, load when it ended, and versions."""

    processor: str
    threads: int
    precision: str
    load: float
    torch: str
    python: str


class Record(_Said):
    """One image.

    Attributes:
        fold: number of its test set, from 1.
        image, object: names; None for an unknown object.
        verdict: see :class:`grasp_bench.learning.evaluation.metric.Judged`.
        iou: largest overlap with a label of similar angle.
        milliseconds, cpu_milliseconds: from image to grasps, on the clock and on the processor.
        labels, dropped: rectangles that count, and those left out for NaN or no area.
        grasp: x, y [px], angle [rad] and width [px] of the best grasp, in pixels of what was shown; None for
            none, and in older files.
        error: what the predictor raised, or what was wrong with its answer; None where all was well.
    """

    fold: int
    image: str
    object: str | None
    verdict: Verdict
    iou: float
    milliseconds: float
    cpu_milliseconds: float
    labels: int
    dropped: int
    grasp: tuple[float, float, float, float] | None = None
    error: str | None = None


class Evaluation(_Part):
    """A result, as its JSON file has it.

    Attributes:
        predictor: name or Python path.
        weights: what a network's weights say; None for anything else.
        dataset, split, protocol, seed: what was asked, see
            :class:`grasp_bench.learning.evaluation.evaluate.Question`.
        conventions: what the protocol means, by name.
        found: a sentence on the copy of the data set.
        images_in_full: number of images of the whole data set.
        object_ids: whether the copy says what each image shows.
        missing: files without which images were left out.
        folds, how: the test sets in order, and how they were made.
        depth: kind of depth images; None where there is only one.
        correct, images, rate, wilson95: best grasps that are right, of how many, with 95 % interval.
        verdicts: number of images by verdict.
        dropped_rectangles: labels left out for NaN or no area.
        latency_ms, machine: times, and the machine they were measured on.
        records: one for each image.
    """

    format: Literal[1] = 1
    kind: Literal["evaluation"] = "evaluation"
    predictor: str
    weights: Weights | None
    dataset: AnyDataset
    split: Split
    protocol: Protocol
    conventions: dict[str, str]
    seed: int
    found: str
    images_in_full: int
    object_ids: bool
    missing: list[str]
    folds: list[Fold]
    how: str
    depth: str | None
    correct: int
    images: int
    rate: float
    wilson95: tuple[float, float]
    verdicts: dict[Verdict, int]
    dropped_rectangles: int
    latency_ms: Latency
    machine: Machine
    records: list[Record]

    @property
    def trained(self) -> FoldTraining | None:
        """The training for the first fold that has one; those of the others are alike."""
        return next((f.trained for f in self.folds if f.trained), None)

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a file; raise ResultsError naming one that is no such result."""
        try:
            found = strict_json(read_text(path))
            if found["kind"] != "evaluation" or found["format"] != 1:
                raise ValueError(f"kind {found['kind']!r}, format {found['format']!r}")
            return cls.model_validate(found)
        except (OSError, ValueError, KeyError, TypeError) as error:
            reason: object = error
            if isinstance(error, ValidationError):
                first = error.errors()[0]
                reason = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
            raise ResultsError(
                f"{path} is no result of `grasp-bench evaluate --out` ({reason}); move it away "
                f"or make it again."
            ) from error

    def text(self) -> str:
        """Return the content of the file, without the line break at its end."""
        return json.dumps(self.model_dump(mode="json"), indent=1, ensure_ascii=False)

    def write(self, path: Path) -> None:
        """Write the file, at once or not at all, and the folders above it where they are missing."""
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, (self.text() + "\n").encode())
