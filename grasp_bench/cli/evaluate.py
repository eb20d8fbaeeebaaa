"""``grasp-bench evaluate`` and ``grasp-bench bench-table``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from grasp_bench.cli.output import put
from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.networks.registry import input_kind
from grasp_bench.networks.store import shipped_file
from grasp_bench.runs.evaluation import AnyDataset, Protocol, Record, Split
from grasp_bench.system.progress import counting

if TYPE_CHECKING:
    from grasp_bench.learning.evaluation.protocols import Case
    from grasp_bench.runs.record import TrialRecord

Format = Literal["table", "markdown", "json"]


def evaluate_command(
    dataset: Annotated[AnyDataset, typer.Option(help="What the folder holds.")],
    root: Annotated[Path, typer.Option(help="Folder of a full or partial copy, or of generated scenes.")],
    predictor: Annotated[
        str | None,
        typer.Option(
            help="A name from `grasp-bench predictors`, a network, or my_module:MyPredictor.",
            show_default="htc-grasp",
        ),
    ] = None,
    split: Annotated[
        Split,
        typer.Option(
            help="Folds of images at random, or of whole objects (contiguous blocks where objects are "
            "unknown)."
        ),
    ] = "object",
    protocol: Annotated[
        Protocol,
        typer.Option(
            help="strict: no crop by the labels, no augmentation. legacy: the GG-CNN lineage's conventions."
        ),
    ] = "strict",
    folds: Annotated[int, typer.Option(help="Test sets, that together hold every image.", min=1)] = 1,
    fold: Annotated[int | None, typer.Option(help="Evaluate this fold alone, from 1.", min=1)] = None,
    weights: Annotated[
        Path | None, typer.Option(help="Weights instead of shipped ones; they say of which network they are.")
    ] = None,
    depth: Annotated[Literal["perfect", "stereo"], typer.Option(help="Depth of Jacquard.")] = "perfect",
    seed: Annotated[int, typer.Option(help="Seed of the folds and of the training.", min=0)] = 0,
    train_steps: Annotated[
        int,
        typer.Option(
            help="Train this many steps for each fold on all others; 0 = evaluate the weights as they are.",
            min=0,
        ),
    ] = 0,
    init: Annotated[
        str, typer.Option(help="Weights that training begins with: 'shipped', 'none', or a file.")
    ] = "shipped",
    kind: Annotated[
        str | None,
        typer.Option("--input", help="What the trained network is shown: rgbd, rgb, depth or rgd."),
    ] = None,
    data: Annotated[
        list[Path] | None, typer.Option("--data", "-d", help="Generated scenes to mix into the training.")
    ] = None,
    real_share: Annotated[float, typer.Option(help="Share of real images among what is seen.")] = 0.5,
    batch: Annotated[int, typer.Option(help="Samples a step.", min=1)] = 16,
    lr: Annotated[float, typer.Option(help="Highest learning rate.")] = 3e-4,
    threads: Annotated[int, typer.Option(help="Threads of the training.", min=1)] = 1,
    runs: Annotated[
        Path | None,
        typer.Option(
            help="Folder of the trainings; by default one in runs/ named by data set and predictor."
        ),
    ] = None,
    fmt: Annotated[Format, typer.Option("--format", help="table, markdown or json.")] = "table",
    rim: Annotated[
        int, typer.Option(help="Width of the rim in which grasps do not count \\[px]; legacy: 20.", min=0)
    ] = 0,
    pictures: Annotated[
        Path | None, typer.Option(help="Draw each image whose best grasp is wrong into this folder.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the result as JSON here, with each image's.")
    ] = None,
) -> None:
    """Evaluate a predictor by the rectangle metric, beside the rows of the paper's Tables 1 and 2.

    Example: grasp-bench evaluate --dataset cornell --root cornell --folds 5 --train-steps 150 --data synth
    """
    from rich.console import Console

    from grasp_bench.learning.evaluation.evaluate import Question, evaluate
    from grasp_bench.learning.evaluation.fold_training import Training
    from grasp_bench.learning.evaluation.pictures import draw_failure
    from grasp_bench.predictors.names import Trained
    from grasp_bench.report.accuracy import accuracy_table, summary
    from grasp_bench.report.tables import markdown, show

    console = Console(stderr=fmt != "table")
    name = predictor or ("htc-grasp" if weights is None else Trained(str(weights)).network)
    question = Question(name, dataset, root, split, protocol, folds, fold, weights, depth, seed, rim)
    if rim and protocol == "legacy":
        raise GraspBenchError("--rim is for --protocol strict; legacy always leaves out 20 px.")
    training = None
    if kind is not None and not train_steps:
        raise GraspBenchError("--input is for --train-steps; weights are shown what they were trained on.")
    if train_steps:
        shown = input_kind(name, kind)  # only networks can be trained; the error lists them
        if weights is not None:
            raise GraspBenchError("--weights is evaluated as it is; with --train-steps, give it as --init.")
        begin = {"shipped": shipped_file(name).path, "none": None}.get(init, Path(init))
        config = TrainConfig(
            network=name,
            input=shown if kind else None,
            steps=train_steps,
            batch=batch,
            lr=lr,
            seed=seed,
            threads=threads,
            warmup=min(20, train_steps),
            checkpoint_every=train_steps,
            validate_every=train_steps,
        )
        where = runs or Path("runs") / f"evaluate-{dataset}-{name}"
        training = Training(config, begin, data or [], real_share, where)
    tally = {"done": 0, "correct": 0}
    with console.status("Evaluating …") as status:

        def report(record: Record, case: Case) -> None:
            tally["done"] += 1
            tally["correct"] += record.verdict == "correct"
            if pictures is not None and record.verdict != "correct":
                draw_failure(record, case, pictures)
            status.update(f"{tally['correct']} of {tally['done']} correct")

        result = evaluate(question, training, report)
    if out is not None:
        result.write(out)
    if pictures is not None and (wrong := tally["done"] - tally["correct"]):
        console.print(f"{wrong} pictures of wrong grasps are in {pictures}.", markup=False, highlight=False)
    table = accuracy_table(dataset, [result])
    if fmt == "json":
        typer.echo(result.text())
    elif fmt == "markdown":
        typer.echo(markdown([table]), nl=False)
    else:
        console.print("\n".join(summary(result)), markup=False, highlight=False)
        show([table], console)


def bench_table_command(
    folder: Annotated[
        Path, typer.Option(help="Holds a run for each predictor; unfinished ones are continued.")
    ] = Path("results/bench"),
    predictors: Annotated[
        str | None,
        typer.Option(help="Names, comma-separated; by default all shipped ones whose weights are installed."),
    ] = None,
    trials: Annotated[
        int | None, typer.Option(help="Trials for each; by default one for each object.", min=1)
    ] = None,
    scenario: Annotated[str, typer.Option(help="A shipped scenario, or the path of a YAML file.")] = "table4",
    seed: Annotated[int, typer.Option(help="Seed of all that is random.", min=0)] = 0,
    workers: Annotated[
        int | None, typer.Option(help="Processes; by default one for each core.", min=1)
    ] = None,
    reference: Annotated[
        str, typer.Option(help="Predictor that the others are compared with.")
    ] = "htc-grasp",
    evaluations: Annotated[
        Path, typer.Option(help="Results of `grasp-bench evaluate --out`, for Tables 1 to 3.")
    ] = Path("results/evaluation"),
    no_run: Annotated[bool, typer.Option("--no-run", help="Print what is there; try nothing.")] = False,
    fmt: Annotated[Format, typer.Option("--format", help="table, markdown or json.")] = "table",
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write to this file instead.")] = None,
) -> None:
    """Try all predictors on the same trials, and print the paper's tables measured again.

    The same command goes on where a stopped one ended.
    """
    from rich.console import Console

    from grasp_bench.studies import bench_table as bench

    progress = Console(stderr=True)
    if not no_run:
        names = [n.strip() for n in predictors.split(",") if n.strip()] if predictors else None
        with counting(progress) as bar:
            tasks = {n: bar.add_task(n, total=trials, state="") for n in bench.chosen(names)}
            won = dict.fromkeys(tasks, 0)

            def count(name: str, record: TrialRecord, resumed: bool) -> None:
                won[name] += record.success
                bar.update(tasks[name], advance=1, state=f"{won[name]} lifted")

            missing = bench.bench(folder, names, trials, scenario, seed, workers, count)
        for name in missing:
            progress.print(f"[yellow]{name} left out: its weights are not installed.[/yellow]")
    comparison = bench.compare(bench.run_folders(folder), reference)
    results = bench.read_evaluations(evaluations)
    short = [r.model_dump(mode="json", exclude={"records"}) for r in results]
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
    put(bench.tables(comparison, results), comparison | {"evaluations": short}, fmt, out)
