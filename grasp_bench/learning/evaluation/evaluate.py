"""Evaluation on Cornell, Jacquard or synthetic scenes, with or without training for each fold."""

from __future__ import annotations

import os
import platform
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.data.folds import make_folds
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.scenes import load_scene, read_index
from grasp_bench.learning.evaluation.fold_training import Training, train_fold
from grasp_bench.learning.evaluation.protocols import (
    CONVENTIONS,
    Answer,
    Case,
    best_grasp,
    judge_answer,
    make_case,
)
from grasp_bench.learning.training.augment import View, crop_scene
from grasp_bench.networks.registry import NETWORKS
from grasp_bench.networks.spec import Kind
from grasp_bench.predictors.names import load_predictor, with_weights
from grasp_bench.predictors.network import NetworkPredictor
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.runs.evaluation import (
    AnyDataset,
    Evaluation,
    Fold,
    FoldTraining,
    Latency,
    Machine,
    Protocol,
    Record,
    Split,
    Verdict,
    Weights,
)
from grasp_bench.runs.statistics import wilson
from grasp_bench.system.machine import cpu_name

CROP = 224
"""Side of what predictors are shown, unless a network's input is another [px]."""

Report = Callable[[Record, Case], None]
"""Called with the record of each image, and what was shown."""


@dataclass(frozen=True)
class Question:
    """What is evaluated on what.

    Attributes:
        root: folder of the data set.
        split: how folds are made; see :func:`grasp_bench.learning.data.folds.make_folds`.
        protocol: a key of :data:`~grasp_bench.learning.evaluation.protocols.CONVENTIONS`.
        folds: number of test sets; together they are all images.
        only: fold (from 1) that alone is evaluated; None for all.
        weights: file that a network uses instead of the shipped one.
        depth: which of Jacquard's is read, 'perfect' or 'stereo'.
        seed: makes the folds, and what 'legacy' draws.
        rim: grasps nearer to the picture's edge than this do not count [px], as in the lineage's search for
            peaks; 'legacy' has its own 20 px.
    """

    predictor: str
    dataset: AnyDataset
    root: Path
    split: Split = "object"
    protocol: Protocol = "strict"
    folds: int = 1
    only: int | None = None
    weights: Path | None = None
    depth: str = "perfect"
    seed: int = 0
    rim: int = 0

    @property
    def conventions(self) -> dict[str, str]:
        """What the protocol does, by name, with what was asked for besides."""
        rim = {"rim": f"grasps within {self.rim} px of the picture's edge do not count"} if self.rim else {}
        return CONVENTIONS[self.protocol] | rim


def evaluate(
    question: Question, training: Training | None = None, report: Report = lambda record, case: None
) -> Evaluation:
    """Answer a question, with training for each fold if ``training`` is given.

    A predictor that fails on an image has that image wrong, and no more.

    Raises:
        AssetError: when data or weights are missing or damaged.
        GraspBenchError: when the question's settings do not go together.
    """
    if question.dataset == "synthetic":
        if training is not None:
            raise GraspBenchError(
                "Training for each fold is for Cornell and Jacquard; "
                "use `grasp-bench train` for synthetic scenes."
            )
        return _evaluate_synthetic(question, report)
    collection = open_collection(question.root, question.dataset, question.depth)
    folds = make_folds([e.object for e in collection.entries], question.folds, question.split, question.seed)
    if question.only is not None and not 1 <= question.only <= question.folds:
        raise GraspBenchError(f"--fold must be from 1 to {question.folds}, not {question.only}.")
    wanted = range(question.folds) if question.only is None else [question.only - 1]
    records: list[Record] = []
    parts: list[Fold] = []
    trained: FoldTraining | None = None
    predictor: Predictor | None = None
    for fold in wanted:
        if training is not None:
            path, trained = train_fold(question.predictor, training, collection, folds, fold)
            predictor = _prepared(NetworkPredictor(question.predictor, path), question)
        elif predictor is None:
            predictor = _load(question)
            collection.require(_seen_by(predictor, question.predictor), question.predictor)
        crop = getattr(predictor, "crop", CROP)
        cases = (make_case(collection, i, crop, question.protocol, question.seed) for i in folds.test[fold])
        found = list(_judge_all(predictor, cases, question, report, fold + 1))
        records += found
        correct = sum(r.verdict == "correct" for r in found)
        parts.append(Fold(fold=fold + 1, correct=correct, images=len(found), trained=trained))
    return _result(
        question,
        records,
        predictor,
        found=collection.describe(),
        images_in_full=collection.images_in_full,
        object_ids=collection.knows_objects,
        missing=collection.missing,
        folds=parts,
        how=folds.how if question.folds > 1 else "all images once",
        depth=question.depth if question.dataset == "jacquard" else None,
    )


def _load(question: Question) -> Predictor:
    name = question.predictor
    if question.weights is None and name in NETWORKS and name not in SHIPPED:
        return _prepared(NetworkPredictor(name), question)  # says that its weights are missing
    predictor = load_predictor(name if question.weights is None else with_weights(name, question.weights))
    return _prepared(predictor, question) if isinstance(predictor, NetworkPredictor) else predictor


def _seen_by(predictor: Predictor, name: str) -> Kind:
    """Return what a predictor looks at; one that is not known may do with colour."""
    if isinstance(predictor, NetworkPredictor):
        return predictor.kind
    return "rgbd" if name in SHIPPED else "rgb"


def _prepared(network: NetworkPredictor, question: Question) -> Predictor:
    """Let a network take the table off by itself, and pay now for what only its first call does."""
    network.level = "none" if question.dataset == "synthetic" else "table"
    side = network.crop
    nothing = np.zeros((side, side, 3), np.uint8), np.zeros((side, side), np.float32)
    network.predict(RgbdImage(*nothing, Intrinsics.from_fov(side, side, 1.0)))
    return network


def _judge_all(
    predictor: Predictor, cases: Iterator[Case], question: Question, report: Report, fold: int = 1
) -> Iterator[Record]:
    for i, case in enumerate(cases):
        if not len(case.rectangles):
            continue  # all labels lie outside of the picture: no answer could be right
        rng = np.random.default_rng(i)
        answer = best_grasp(predictor, case, question.protocol, rng, question.rim)
        record = _record(answer, case, question.protocol, fold)
        report(record, case)
        yield record


def _record(answer: Answer, case: Case, protocol: Protocol, fold: int) -> Record:
    judged, best = judge_answer(answer, case, protocol), answer.grasp
    said: dict[str, Any] = {"error": answer.error} if answer.error is not None else {}
    if best is not None:
        said["grasp"] = tuple(round(v, 4) for v in (best.x, best.y, best.angle, best.width))
    return Record(
        fold=fold,
        image=case.name,
        object=case.object,
        verdict=judged.verdict,
        iou=round(judged.iou, 4),
        milliseconds=round(1e3 * answer.seconds, 2),
        cpu_milliseconds=round(1e3 * answer.cpu, 2),
        labels=len(case.rectangles),
        dropped=case.dropped,
        **said,
    )


def _evaluate_synthetic(question: Question, report: Report) -> Evaluation:
    predictor = _load(question)
    crop = getattr(predictor, "crop", CROP)
    cases, total = _synthetic_cases(question.root, crop)
    if question.protocol != "strict" or question.folds != 1:
        raise GraspBenchError(
            "Synthetic scenes have one protocol, strict, and their own held-out scenes; "
            "leave out --protocol and --folds."
        )
    records = list(_judge_all(predictor, cases, question, report))
    return _result(
        question,
        records,
        predictor,
        found=f"synthetic scenes in {question.root.name}: {len(records)} held-out scenes with good "
        f"grasps in view, of {total}",
        images_in_full=total,
        object_ids=True,
        missing=[],
        folds=[],
        how="scenes of the split 'val'",
        depth="sensed",
    )


def _synthetic_cases(root: Path, crop: int) -> tuple[Iterator[Case], int]:
    """Return held-out scenes whose middle has a listed grasp, and how many were held out in all."""
    entries = [e for e in read_index(root) if e["split"] == "val"]

    def cases() -> Iterator[Case]:
        for entry in entries:
            scene = load_scene(root / entry["file"], crop)
            rgb, depth, _ = crop_scene(scene, View(), crop)
            grasps = [View().grasp(g, scene.size, crop) for g in scene.truths()]
            inside = [g.rectangle() for g in grasps if 0 <= g.x < crop and 0 <= g.y < crop]
            if inside:
                yield Case(scene.name, None, rgb, depth, np.array(inside))

    return cases(), len(entries)


# ---------------------------------------------------------------- result


def _result(question: Question, records: list[Record], predictor: Any, **facts: Any) -> Evaluation:
    import torch

    if not records:
        raise GraspBenchError(f"{question.root} holds nothing that could be evaluated.")
    counts = Counter(r.verdict for r in records)
    times = [r.milliseconds for r in records]
    return Evaluation(
        predictor=question.predictor,
        weights=weights_facts(predictor),
        dataset=question.dataset,
        split=question.split,
        protocol=question.protocol,
        conventions=question.conventions,
        seed=question.seed,
        correct=counts["correct"],
        images=len(records),
        rate=counts["correct"] / len(records),
        wilson95=wilson(counts["correct"], len(records)),
        verdicts={v: counts[v] for v in get_args(Verdict)},
        dropped_rectangles=sum(r.dropped for r in records),
        latency_ms=Latency(
            median=round(float(np.median(times)), 2),
            p95=round(float(np.percentile(times, 95)), 2),
            cpu_median=round(float(np.median([r.cpu_milliseconds for r in records])), 2),
        ),
        machine=Machine(
            processor=cpu_name(),
            threads=1,
            precision="float32",
            load=round(os.getloadavg()[0], 2),
            torch=torch.__version__,
            python=platform.python_version(),
        ),
        records=records,
        **facts,
    )


def weights_facts(predictor: Any) -> Weights | None:
    """Return what the weights of a network say of their training; None for anything else."""
    metadata = getattr(predictor, "metadata", None)
    if not isinstance(metadata, dict):
        return None
    return Weights.model_validate({k: metadata[k] for k in Weights.model_fields if k in metadata})
