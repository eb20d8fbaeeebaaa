"""Models of MuJoCo Menagerie by name, through its own package, which downloads them when first asked for."""

from __future__ import annotations

from pathlib import Path

from grasp_bench.errors import AssetError

PREFIX = "menagerie:"


def model_of(source: Path) -> Path:
    """Return the file that ``source`` means: itself, or for ``menagerie:NAME[/ENTRY]`` the model's.

    ENTRY is one of the model's files, without ``.xml``; by default the robot alone, without a scene.

    Raises:
        AssetError: in one line, where the package is not installed, does not know the name, or cannot
            download it.
    """
    text = source.as_posix()
    if not text.startswith(PREFIX):
        return source
    name, _, entry = text.removeprefix(PREFIX).partition("/")
    try:
        import mujoco_menagerie
    except ImportError as error:
        raise AssetError(
            f"{text} needs the package mujoco-menagerie: pip install 'grasp-bench[menagerie]'; it downloads "
            "the model when first asked for."
        ) from error
    try:
        robot = mujoco_menagerie.get(name)
        return robot.path() / robot.entry(entry or robot.default_model).file
    except mujoco_menagerie.MenagerieError as error:
        raise AssetError(f"{text}: {' '.join(str(error).split())}") from error
