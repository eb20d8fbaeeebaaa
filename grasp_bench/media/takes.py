"""One try at an object with all that pictures, films and logs show of it.

A trial is one take; an episode of clutter is several, each in a world of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

from grasp_bench.errors import GraspBenchError
from grasp_bench.grasps import GraspMaps
from grasp_bench.media.pictures import Rgb, close_to, crop_for, depth, proposed, seen
from grasp_bench.media.recording import Moment, Recording, moment
from grasp_bench.predictors.guard import Guard
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.trials.attempt import Trial


@dataclass(frozen=True)
class Take:
    """A finished try.

    Attributes:
        done: image, grasps, plan, world and record of the try.
        moments: its states in order, the end last; empty where there never was a world.
        maps: the predictor's dense answer, None for predictors without.
        origin: (x, y) of the maps' corner in the image [px].
        attempt: number in its episode, from 0; None for a single trial.
    """

    done: Trial
    moments: Sequence[Moment]
    maps: GraspMaps | None = None
    origin: tuple[int, int] = (0, 0)
    attempt: int | None = None

    @classmethod
    def of(cls, done: Trial, recording: Recording, predictor: Any, attempt: int | None = None) -> Self:
        """Return the take of a try that ended just now, before its predictor is asked about another.

        Args:
            done: the try.
            recording: the recording that watched it.
            predictor: the predictor asked; its ``last_maps`` and ``crop_origin`` are taken if it has them.
            attempt: number in its episode.
        """
        moments = list(recording.moments)
        if done.world is not None:
            moments.append(moment(done.world, recording.touches))
        failed = done.record.outcome == Outcome.ERROR  # what a predictor has then is of an earlier image
        with Guard("the predictor's last_maps or crop_origin raised"):
            maps = None if failed else getattr(predictor, "last_maps", None)
            origin = getattr(predictor, "crop_origin", (0, 0))
        return cls(done, moments, maps, origin, attempt)

    @property
    def name(self) -> str:
        """The trial's number, and that of the attempt of an episode."""
        trial = f"trial {self.done.record.trial}"
        return trial if self.attempt is None else f"{trial}, attempt {self.attempt}"

    @property
    def moved(self) -> bool:
        """Whether the arm moved, so that there is more than an end to show."""
        return len(self.moments) > 1

    @property
    def start(self) -> float:
        """Simulated time of the first state [s]."""
        return self.moments[0].time if self.moments else 0.0

    @property
    def seen(self) -> bool:
        """Whether there is an image, so that there is something to show."""
        return self.done.image is not None and self.done.world is not None

    def pictures(self, close: bool = False) -> dict[str, Rgb]:
        """Draw what was ``seen``, its ``depth``, and what was ``proposed``: squares of one part of the image.

        Args:
            close: show the surroundings of the grasp that was carried out only.

        Raises:
            GraspBenchError: for what ended before there was an image.
        """
        image, grasp = self.done.image, self.done.record.grasp
        if image is None:
            raise GraspBenchError(
                f"{self.name.capitalize()} ended before there was an image "
                f"({self.done.record.outcome}); there is nothing to show."
            )
        crop = close_to(image, grasp) if close else crop_for(image, [] if grasp is None else [grasp])
        return {
            "seen": seen(image, crop, grasp),
            "depth": depth(image, crop, grasp),
            "proposed": proposed(image, crop, self.done.grasps, grasp, self.maps, self.origin),
        }
