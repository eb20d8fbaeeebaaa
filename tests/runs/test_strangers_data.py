"""Results folders and scenarios of strangers: they do not act, and end as data or as one clear line."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_runs import RUN, finish, record, write_run

import grasp_bench
from grasp_bench.api import default_folder
from grasp_bench.errors import GraspBenchError, ScenarioError
from grasp_bench.media.store import faults, find
from grasp_bench.replay.rebuild import settings_of
from grasp_bench.report import leaderboard
from grasp_bench.report.gate import check
from grasp_bench.report.gate_text import as_markdown
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import markdown
from grasp_bench.runs.folder import load_records, load_run
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.lines import LONGEST_LINE, parse
from grasp_bench.runs.merge import merge
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.system.integrity import write_whole

Cli = Callable[[str], Any]
DEEP: Any = []
for _ in range(200):
    DEEP = [DEEP]
ODD: dict[str, Any] = {
    "null": None,
    "number": 5,
    "fraction": 0.5,
    "negative": -1,
    "400 digits": 10**400,
    "20 digits": 10**19,
    "huge": 1e308,
    "text": "x",
    "empty": "",
    "surrogate": "\ud800",
    "escapes": "\x1b[2J\x07\x00",
    "markup": "[red]<script>|`*[x](javascript:alert(1))\n# h",
    "long": "x" * 100_000,
    "list": [],
    "list of lists": [[1, [2]]],
    "object": {},
    "nested": {"a": {"b": [None, {}]}},
    "true": True,
    "deep": DEEP,
}


def clear(ended: Any) -> None:
    """What a command says of a stranger's folder is short, and no traceback."""
    assert ended.code in (0, 1, 2, 3), ended
    if ended.code == 2:
        assert "Error" in ended.err
        assert len(ended.err) < 3000
    for text in (ended.out, ended.err):
        assert "Traceback" not in text
        assert "\x1b[2J" not in text


def looked_at(folder: Path, sound: Path) -> None:
    """All that only reads a run gives text, or one short error."""
    for look in (
        lambda: markdown(build_report([folder], folder.parent).tables()),
        lambda: json.dumps(build_report([folder], folder.parent).to_json()),
        lambda: as_markdown(check(folder, sound)),
        lambda: str(merge(folder / "merged", [folder], partial=True)),
        lambda: str(leaderboard.check(folder)),
        lambda: str(settings_of(load_run(folder), folder, None, False)),
    ):
        try:
            told = look()
        except GraspBenchError as error:
            told = str(error)
        told.encode()
        assert "\x1b[2J" not in told


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    return finish(write_run(tmp_path / "sound"))


@pytest.mark.parametrize("odd", ODD)
@pytest.mark.parametrize("where", ["run", "scenario", "record"])
def test_whatever_stands_in_a_run_is_read_or_refused_in_a_line(where: str, odd: str, sound: Path) -> None:
    run = json.loads((sound / "run.json").read_text())
    lines = (sound / "trials.jsonl").read_text().splitlines(keepends=True)
    keys = {
        "run": [*RUN, "implementation", "shard", "unheard"],
        "scenario": ["objects", "clutter", "version", "name", "camera"],
        "record": [*record(0), "grasp", "pose", "rank", "tcp_error", "sim_steps", "clutter", "unheard"],
    }[where]
    for key in keys:
        folder = sound.parent / f"odd-{key}"
        shutil.copytree(sound, folder)
        changed = {key: ODD[odd]}
        if where == "record":
            lines[4] = json.dumps(record(4) | changed) + "\n"
            (folder / "trials.jsonl").write_text("".join(lines))
        else:
            content = run | (changed if where == "run" else {"scenario": run["scenario"] | changed})
            (folder / "run.json").write_text(json.dumps(content))
        looked_at(folder, sound)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("run.json", '{"format": 1, "format": 1}'),
        ("run.json", "[" * 100_000),
        ("run.json", '{"a":' * 5000 + "1" + "}" * 5000),
        ("run.json", "\ufeff{}"),
        ("run.json", '{"seed": NaN}'),
        ("run.json", '{"seed": ' + "9" * 5000 + "}"),
        ("trials.jsonl", '{"trial": 0, "trial": 1}\n{}\n'),
        ("trials.jsonl", "[" * 100_000 + "\n\n"),
        ("trials.jsonl", '{"trial": ' + "9" * 5000 + "}\n{}\n"),
        ("trials.jsonl", "\n\n\n"),
    ],
)
def test_text_that_is_no_record_is_one_line_that_names_the_file(
    name: str, text: str, cli: Cli, tmp_path: Path
) -> None:
    folder = finish(write_run(tmp_path / "run"))
    (folder / name).write_text(text)
    ended = cli(f"report {folder}")
    assert ended.code == 2
    assert str(folder / name) in ended.err
    clear(ended)


def test_a_key_that_comes_twice_is_named(tmp_path: Path, cli: Cli) -> None:
    folder = finish(write_run(tmp_path / "run"))
    path = folder / "run.json"
    path.write_text(path.read_text().replace('"seed": 4', '"seed": 4, "seed": 5'))
    assert "the key 'seed' comes twice" in cli(f"report {folder}").err


@pytest.mark.parametrize("name", ["run.json", "trials.jsonl", "timings.jsonl", "about.yaml"])
def test_named_pipes_and_folders_in_the_place_of_files_hold_nobody(
    name: str, cli: Cli, tmp_path: Path
) -> None:
    for number, make in enumerate((os.mkfifo, os.mkdir)):
        folder = finish(write_run(tmp_path / f"run{number}"))
        (folder / name).unlink(missing_ok=True)
        make(folder / name)
        for words in (
            "report {0}",
            "leaderboard check {0}",
            "check {0} --baseline {0}",
            "replay {0} --trial 0",
        ):
            clear(cli(words.format(folder)))


# ---------------------------------------------------------------- data do not act


@pytest.fixture
def foreign(tmp_path: Path) -> Callable[[str], Path]:
    def make(predictor: str) -> Path:
        return finish(
            write_run(tmp_path / "row", predictor=predictor, scenario={"name": "table4", "version": 2})
        )

    return make


@pytest.mark.parametrize(
    "words", ["doctor row", "replay row --trial 0", "report row --format html --render all"]
)
@pytest.mark.parametrize("predictor", ["cmd: touch PWNED {port}", "evil:Evil", "http://127.0.0.1:9/x"])
def test_a_record_starts_nothing_unless_it_is_trusted(
    predictor: str, words: str, foreign: Callable[[str], Path], cli: Cli, tmp_path: Path
) -> None:
    foreign(predictor)
    (tmp_path / "evil.py").write_text("open('PWNED', 'w')")
    ended = cli(words)
    assert ended.code == 2
    assert "--trust" in ended.err
    assert not (tmp_path / "PWNED").exists()
    told = cli(f"{words} --trust")
    assert told.code in (1, 2)
    assert "--trust" not in told.err


def test_links_in_media_lead_nowhere(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(b"RIFF0000WEBP my private key")
    for name in ("link", "hard", "folder", "pipe", "text"):
        (tmp_path / name).mkdir()
    for name in ("link", "pipe", "text"):
        (tmp_path / name / "media").mkdir()
    (tmp_path / "link" / "media" / "00001.webp").symlink_to(secret)
    (tmp_path / "link" / "media" / "00001.txt").symlink_to(secret)
    (tmp_path / "away").mkdir()
    (tmp_path / "away" / "00001.webp").write_bytes(secret.read_bytes())
    (tmp_path / "folder" / "media").symlink_to(tmp_path / "away")
    os.mkfifo(tmp_path / "pipe" / "media" / "00001.webp")
    (tmp_path / "text" / "media" / "00001.webp").write_text("no picture")
    for name in ("link", "folder", "pipe", "text"):
        assert find(tmp_path / name, 1).sheet is None, name
    assert faults(tmp_path / "link") == {}


def test_stray_files_in_media_are_left_alone(tmp_path: Path) -> None:
    media = tmp_path / "media"
    media.mkdir()
    for name in ("notes.txt", "1-2-3.txt", "٣٣٣٣٣.txt", "00002-x.txt", "-.txt"):
        (media / name).write_text("mine")
    (media / "00003-02.txt").write_bytes(b"\xff\x1b[2J")
    (media / "00004.txt").write_text("a full disk\x1b[2J")
    assert list(faults(tmp_path)) == [3, 4]
    assert faults(tmp_path)[4] == "a full disk\ufffd[2J"


def test_what_is_written_does_not_follow_a_link(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.write_text("mine")
    (tmp_path / "report.html.part").symlink_to(mine)
    (tmp_path / "report.html").symlink_to(mine)
    write_whole(tmp_path / "report.html", b"page")
    assert mine.read_text() == "mine"
    assert (tmp_path / "report.html").read_text() == "page"
    folder = write_run(tmp_path / "run", only=[0])
    (folder / "trials.jsonl").unlink()
    (folder / "trials.jsonl").symlink_to(mine)
    with pytest.raises(Exception, match="is a link"):
        write_run(folder)
    assert mine.read_text() == "mine"


@pytest.mark.parametrize(
    "name", ["x/../../../ESCAPED", "a\0b", "..", "/etc/x", "\udcff", "", "x" * 5000, "a\nb", "-rf", "~"]
)
def test_a_scenarios_name_stays_in_the_folder_of_results(name: str) -> None:
    folder = default_folder("random", name, 0)
    assert folder.parent == Path("results")
    assert len(folder.name) < 200
    assert folder.name.isprintable()
    folder.name.encode()


# ---------------------------------------------------------------- YAML

BOMB = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"{c}: &{c} [{','.join(['*' + p] * 9)}]\n" for p, c in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    "text",
    [
        BOMB + "name: *i\n",
        "a: &a [*a]\nname: x\n",
        "a: &a {b: *a}\n",
        "description: 2024-13-45\n",
        "description: 2024-02-30 25:61:61\n",
        "camera: {width: 0b_}\n",
        "camera: {width: 0x}\n",
        "camera: {width: " + "9" * 5000 + "}\n",
        "camera: {width: " + "9" * 400 + "}\n",
        "camera: {horizontal_fov_deg: " + "9" * 400 + "}\n",
        "camera: {position: [" + "9" * 400 + ", 0, 0]}\n",
        "camera: {position: .inf}\n",
        "name: " + "[" * 5000 + "]" * 5000 + "\n",
        "name: " + "{a: " * 300 + "}" * 300 + "\n",
        "name: !!python/object/apply:os.system [true]\n",
        "name: !!binary x\n",
        "name: !!set {a, b}\n",
        "? [a, b]\n: c\n",
        "1: 2\n",
        "null: 2\n",
        "name: a\nname: b\n",
        "camera: {width: 64, width: 65}\n",
        "name: \x00\n",
        "name: [\n",
        "%YAML 9.9\n---\na: b\n",
        "a: b\n---\nc: d\n",
        "- a\n",
        "",
        "extends: 5\n",
        "extends: [table4]\n",
        "extends: ../../../etc/passwd.yaml\n",
        'extends: "a\\0b.yaml"\n',
        "extends: no-such\n",
        "extends: odd.yaml\n",
        "clutter: 5\n",
        "objects: {names: {a: {}}}\n",
        "gripper: {force: {}}\n",
        "gripper: [1]\n",
        "x" * 100_000 + ": 1\n",
        "camera: {" + ", ".join(f"k{i}: 1" for i in range(2000)) + "}\n",
        "trial_timeout: -1\n",
        "trial_timeout: .nan\n",
        "=: 5\n",
        "<<: 5\n",
        "<<: [1, 2]\n",
        "description: 12:34:56:78\nphysics: {timestep: 1:2:3}\n",
    ],
)
def test_a_strangers_scenario_is_one_short_error_that_names_the_file(text: str, tmp_path: Path) -> None:
    path = tmp_path / "odd.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(str(path))
    told = str(caught.value)
    assert "odd.yaml" in told
    assert len(told) < 3000
    told.encode()


def test_scenario_files_that_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "folder.yaml").mkdir()
    (tmp_path / "latin.yaml").write_bytes(b"name: caf\xe9\n")
    (tmp_path / "large.yaml").write_text("a: b\n" * 300_000)
    for name in ("pipe", "folder", "latin", "large", "absent"):
        with pytest.raises(ScenarioError, match=f"{name}.yaml"):
            load_scenario(str(tmp_path / f"{name}.yaml"))


def test_a_name_that_is_not_unicode_is_made_legible(tmp_path: Path) -> None:
    path = tmp_path / "odd.yaml"
    path.write_text('extends: table4\nname: "caf\\udce9"\n')
    assert load_scenario(str(path)).name == "caf\ufffd"


def test_anchors_and_merged_keys_are_fine_where_they_are_few(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(
        "extends: table4\nsettling: &s {clearance: 0.002}\ndescription: 2024-01-01 is text\n"
        "success: {<<: {minimum_lift: 0.2}, minimum_lift: 0.1}\n"
    )
    assert load_scenario(str(path)).settling.clearance == 0.002


# ---------------------------------------------------------------- what is written can be read

TEXTS = st.text(st.characters(codec=None), max_size=50)
LONG = st.builds(lambda t, n: t * n, TEXTS, st.sampled_from([0, 1, 50_000]))
PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**30), 10**30)
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=8,
)


@given(
    detail=LONG,
    names=st.tuples(TEXTS, TEXTS),
    lift=st.floats(allow_nan=False, allow_infinity=False),
    seconds=st.dictionaries(
        st.text(max_size=5).filter(lambda k: k != "trial"), st.floats(0, 1e300), max_size=2
    ),
    info=PLAIN,
)
def test_what_is_written_can_be_read(
    tmp_path_factory: pytest.TempPathFactory,
    detail: str,
    names: tuple[str, str],
    lift: float,
    seconds: dict[str, float],
    info: Any,
) -> None:
    record = TrialRecord.read(
        {"trial": 0, "object": names[0], "category": names[1], "outcome": "error", "detail": detail}
        | {"lift_height": lift}
    )
    line = (record.line() + "\n").encode()
    assert len(line) < LONGEST_LINE
    assert line.count(b"\n") == 1
    assert parse(line, TrialRecord).line() == record.line()
    timed = Timings.read({"trial": 0} | seconds)
    assert parse((timed.line() + "\n").encode(), Timings) == timed
    folder = tmp_path_factory.mktemp("run")
    changes = {"predictor": names[0], "implementation": {"info": info}, "command": [detail]}
    run: dict[str, Any] = {k: v for k, v in RUN.items() if k != "trials"} | changes
    write_run(folder, trials=1, only=[], **run)
    assert load_run(folder).to_json() == RunInfo.read(run | {"trials": 1}).to_json()
    assert load_records(folder) == []


def test_yaml_is_read_in_one_place() -> None:
    """Wherever else it were read, aliases without end and keys that come twice would get in."""
    package = Path(grasp_bench.__file__).parent
    reading = re.compile(r"yaml\.\w*load\w*\(|\(yaml\.\w*Loader")
    readers = [p for p in package.rglob("*.py") if reading.search(p.read_text(encoding="utf-8"))]
    assert [p.relative_to(package).as_posix() for p in readers] == ["system/yaml_text.py"]
