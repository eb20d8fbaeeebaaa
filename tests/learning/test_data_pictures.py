"""The sheet of a data set's samples."""

from __future__ import annotations

import numpy as np
import pytest

from grasp_bench.learning.data.pictures import two_a_row


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
