"""The sheet of a data set's samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.data.pictures import two_a_row, write_picture


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_every_strip_is_on_the_sheet(count: int) -> None:
    strips = [np.full((2, 8, 3), 10 * i + 1, np.uint8) for i in range(count)]
    sheet = two_a_row(strips)
    assert sheet.shape == (2 * -(-count // 2), 8 if count == 1 else 16, 3)
    for i in range(count):
        row, column = 2 * (i // 2), 8 * (i % 2)
        assert (sheet[row : row + 2, column : column + 8] == 10 * i + 1).all()
    if count in (3, 5):
        assert (sheet[-2:, 8:] == 255).all()


def test_a_picture_is_written_where_it_was_asked_for_or_not_at_all(tmp_path: Path) -> None:
    picture = np.zeros((4, 6, 3), np.uint8)
    picture[..., 0] = 200
    write_picture(tmp_path / "new" / "a.PNG", picture)
    assert Image.open(tmp_path / "new" / "a.PNG").getpixel((0, 0)) == (200, 0, 0)
    with pytest.raises(GraspBenchError, match=r"samples\.txt is not named like a picture: end it in \.png"):
        write_picture(tmp_path / "samples.txt", picture)
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"Not a directory|File exists"):
        write_picture(tmp_path / "file" / "a.png", picture)
