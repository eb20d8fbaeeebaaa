"""Tables 1 to 3: evaluations beside the paper's rows."""

from __future__ import annotations

from collections.abc import Sequence

from grasp_bench.networks.registry import standing_for
from grasp_bench.report.paper import MISPRINTS, MISPRINTS_3, TABLE_3, TABLES
from grasp_bench.report.tables import Footnotes, TextTable, rate_cells
from grasp_bench.runs.evaluation import Evaluation
from grasp_bench.runs.statistics import Rate

HEAD = ("Method", "Input", "Split", "Correct", "Accuracy", "95 % interval", "ms", "On")
NUMBERS = (3, 4, 5, 6)
TITLES = {
    "cornell": "Table 1, re-measured: Cornell",
    "jacquard": "Table 2, re-measured: Jacquard",
    "synthetic": "Held-out synthetic scenes",
}
NOTE = (
    "Paper rows are as printed: the full data set, counts unknown, times on each author's hardware. "
    "Rows of grasp-bench are measured on the images present here, with the 95 % Wilson interval of k/n, "
    "and the processor time from image to grasps on one core of the machine that each one's JSON names."
)


def accuracy_table(dataset: str, results: Sequence[Evaluation]) -> TextTable:
    """Return Table 1 or 2 of the paper with our rows below; synthetic scenes have only ours."""
    rows = []
    for row in TABLES.get(dataset, ()):
        time = "" if row.milliseconds is None else f"{row.milliseconds:g}"
        for split, rate in (("image", row.image_wise), ("object", row.object_wise)):
            if rate is not None:
                method, shown = f"{row.method} ({row.authors})", split if dataset == "cornell" else ""
                rows.append([method, row.input, shown, "", f"{rate:g}%", "", time, "paper"])
    paper = frozenset(range(len(rows)))
    how = Footnotes()
    rows += [_ours(r, how.mark(conditions(r))) for r in results]
    note = f"{NOTE} {MISPRINTS[dataset]}" if dataset in MISPRINTS else NOTE
    return TextTable(TITLES[dataset], HEAD, rows, note=note, footnotes=how, numbers=NUMBERS, paper=paper)


def _ours(result: Evaluation, mark: str) -> list[str]:
    weights, trained = result.weights, result.trained
    kind = str(weights.input).split(" ")[0] if weights else ""
    how = ""
    if trained:
        how = ", trained per fold"
    elif weights and weights.model_fields_set:
        how = ", weights that saw real images" if weights.saw_real_images else ", zero-shot"
    return [
        result.predictor + how,
        {"rgbd": "RGB-D", "rgb": "RGB", "depth": "D", "rgd": "RGD"}.get(kind, ""),
        result.split if trained else "",
        *rate_cells(Rate(result.correct, result.images)),
        f"{result.latency_ms.cpu_median:.0f}",
        # No line begins with a mark.
        f"{result.images} of {result.images_in_full} {result.protocol}\u00a0{mark}",
    ]


def conditions(result: Evaluation) -> str:
    """Say how a result came about: folds, training, protocol."""
    parts = [result.how]
    if trained := result.trained:
        mixed = f" and {', '.join(trained.synthetic)} (real share {trained.real_share:g})"
        parts.append(
            f"trained for each fold from {trained.begun_with or 'random weights'} by "
            f"{trained.steps} steps of {trained.batch} on the other folds{mixed if trained.synthetic else ''}"
        )
    elif result.weights and (data := result.weights.data):
        steps = result.weights.steps
        parts.append(
            f"weights trained on {', '.join(data.folders)} only, {'?' if steps is None else steps} steps"
        )
    parts.append(f"protocol {result.protocol} ({', '.join(result.conventions)})")
    return ", ".join(parts)


def summary(result: Evaluation) -> list[str]:
    """Return what to say before the table: the data, folds and verdicts."""
    verdicts = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in result.verdicts.items() if v)
    lines = [result.found, f"Labels dropped because of NaN or no area: {result.dropped_rectangles}."]
    if len(result.folds) > 1 or result.trained:
        lines.append(f"{result.how}: {', '.join(f'{f.correct}/{f.images}' for f in result.folds)}.")
    lines.append(f"Protocol {result.protocol}:")
    lines += [f"  {name}: {meaning}" for name, meaning in result.conventions.items()]
    latency, machine = result.latency_ms, result.machine
    lines += [
        f"Best grasps: {verdicts}.",
        *failures(result),
        f"Latency, image to grasps, one thread of {machine.processor}, float32: "
        f"{latency.cpu_median} ms of processor time; on the clock median {latency.median}, "
        f"95th percentile {latency.p95} ms at a load of {machine.load:.1f}.",
    ]
    return lines


def failures(result: Evaluation) -> list[str]:
    """Name the images on which the predictor failed: the first with its error, and how many more."""
    failed = [r for r in result.records if r.verdict == "error"]
    if not failed:
        return []
    first, count = failed[0], len(failed)
    more = f", and {count - 1} more" if count > 1 else ""
    return [
        f"The predictor failed on {count} of {result.images} images, which count as wrong: "
        f"{first.image} ({first.error}){more}. --format json lists all."
    ]


# ---------------------------------------------------------------- Table 3


def ablation_table(results: Sequence[Evaluation]) -> TextTable:
    """Return Table 3 of the paper with what was measured of the same networks beside it."""
    rows, how = [], Footnotes()
    for row in TABLE_3:
        for dataset, printed in (("cornell", row.cornell), ("jacquard", row.jacquard)):
            found = [
                r
                for name in standing_for(3, row.method)
                for r in results
                if r.predictor == name and r.dataset == dataset
            ]
            for r in found or [None]:
                measured = rate_cells(Rate(r.correct, r.images)) if r else ["not measured", "", ""]
                rows.append(
                    [
                        dataset.capitalize(),
                        "✓" if row.external_attention else "",
                        "✓" if row.channel_attention else "",
                        f"{printed:g}%",
                        *measured,
                        f"{r.protocol} {how.mark(conditions(r))}" if r else "",
                    ]
                )
    rows.sort(key=lambda r: r[0])
    switches = ("External attention", "Channel attention")
    head = ("Data set", *switches, "Paper", "Correct", "Here", "95 % interval", "How")
    title = "Table 3, re-measured: ablations"
    without = "Without external attention, blocks have multi-head self-attention (the paper's equation 3)."
    return TextTable(
        title, head, rows, note=f"{without} {NOTE} {MISPRINTS_3}", footnotes=how, numbers=NUMBERS
    )
