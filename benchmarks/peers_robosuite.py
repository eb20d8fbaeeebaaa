"""The peer's part of ``peers.py``: a scripted pick in robosuite's ``Lift``, by an interpreter that has it.

Prints a line of JSON. Nothing of grasp-bench is imported.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from importlib.metadata import version
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

CLOSE, OPEN = 1.0, -1.0
REACH = 0.05
"""What a command of 1 moves the hand by [m]."""
SPEED = 1.0
"""Greatest command on each axis."""
STEPS = 80
"""Commands that one phase may take."""


class Pick:
    """One pick after the other in the same environment."""

    def __init__(self, env: Any) -> None:
        self.env, self.steps, self.seen = env, 0, {}

    def command(self, move: Any, jaws: float) -> None:
        """One command of the operational-space controller."""
        import numpy as np

        action = np.zeros(self.env.action_dim)
        action[:3], action[-1] = np.clip(move / REACH, -SPEED, SPEED), jaws
        self.seen = self.env.step(action)[0]
        self.steps += 1

    def go(self, target: Any, jaws: float, near: float = 0.005) -> None:
        """Straight towards a place, until the hand is within ``near`` [m] of it."""
        import numpy as np

        for _ in range(STEPS):
            error = target - self.seen["robot0_eef_pos"]
            if np.linalg.norm(error) < near:
                return
            self.command(error, jaws)

    def once(self) -> bool:
        """Reset, reach, close, lift, and hold for half a second."""
        import numpy as np

        self.seen = self.env.reset()
        cube = np.array(self.seen["cube_pos"])
        self.go(cube + [0, 0, 0.10], OPEN, near=0.01)
        self.go(cube, OPEN)
        for _ in range(8):
            self.command(np.zeros(3), CLOSE)
        self.go(cube + [0, 0, 0.15], CLOSE, near=0.01)
        for _ in range(10):
            self.command(np.zeros(3), CLOSE)
        return bool(self.env._check_success())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", type=int)
    parser.add_argument("--image", action="store_true", help="a picture of every scene, by OpenGL")
    args = parser.parse_args()
    import mujoco
    import numpy as np
    import robosuite  # pyright: ignore[reportMissingImports]

    env = robosuite.make(
        "Lift",
        robots="Panda",
        has_renderer=False,
        has_offscreen_renderer=args.image,
        use_camera_obs=args.image,
        camera_depths=args.image,
        camera_names="agentview",
        control_freq=20,
        horizon=10_000,
        hard_reset=False,  # the model is kept: several times cheaper than robosuite's default
        reward_shaping=False,
        seed=0,
    )
    pick = Pick(env)
    pick.once()
    pick.once()  # numba compiles in the first ones
    pick.steps, lifted, contacts = 0, 0, []
    began = time.process_time()
    for _ in range(args.trials):
        lifted += pick.once()
        contacts.append(env.sim.data.ncon)
    seconds = (time.process_time() - began) / args.trials
    timestep = float(env.sim.model.opt.timestep)
    simulated = pick.steps / args.trials / env.control_freq
    print(
        json.dumps(
            {
                "name": f"robosuite {version('robosuite')}, Lift" + " with image" * args.image,
                "trials": args.trials,
                "lifted": lifted,
                "seconds": seconds,
                "steps": simulated / timestep,
                "simulated": simulated,
                "timestep": timestep,
                "contacts": float(np.mean(contacts)),
                "mujoco": mujoco.__version__,
            }
        )
    )


if __name__ == "__main__":
    main()
