"""A run from Python: a predictor of your own against a control, on the same trials.

Run it with:  python examples/02_from_python.py
It lifts 2 of 4.
"""

import tempfile

import cv2
import numpy as np

import grasp_bench as gb


class AcrossTheBlob:
    """Grasps the middle of what stands out of the table, across its longer side."""

    def predict(self, image: gb.RgbdImage) -> list[gb.Grasp]:
        table = np.median(image.depth[image.valid])
        blob = image.valid & (image.depth < table - 0.008)
        blob[:, :208] = blob[:, 432:] = False
        points = cv2.findNonZero(blob.astype(np.uint8))
        if points is None or len(points) < 20:
            return []
        (x, y), (long, short), turn = cv2.minAreaRect(points)
        if long < short:
            short, turn = long, turn + 90
        # OpenCV's angle grows clockwise as seen and belongs to the long side; jaws open across it.
        return [gb.Grasp(x, y, -np.radians(turn + 90), width=short + 12, quality=0.5)]


def main() -> None:
    with tempfile.TemporaryDirectory() as out:
        objects = ["coffee_mug", "banana", "claw_hammer", "egg_cup"]
        mine = gb.run(objects, predictor=AcrossTheBlob(), out=f"{out}/mine", progress=False)
        bound = gb.run(objects, predictor="oracle", out=f"{out}/oracle", progress=False)
        print(mine.trials[["object", "outcome", "detail"]].to_string(index=False))
        print(
            f"{mine.successes}/{len(mine)} = {mine.rate:.0%}, 95 % interval "
            f"{mine.interval[0]:.0%} – {mine.interval[1]:.0%}"
        )
        print(mine.compare(bound))


if __name__ == "__main__":
    main()
