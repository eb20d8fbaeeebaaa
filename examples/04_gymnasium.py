"""One grasp an episode with Gymnasium: a random policy beside one that looks.

Run it with:  python examples/04_gymnasium.py     (needs the extra: pip install grasp-bench[gym])
The one that looks lifts 4 of 5, the random one none.
"""

import gymnasium
import numpy as np

import grasp_bench.gym  # noqa: F401  (registers the environment)


def look(observation: dict[str, np.ndarray]) -> np.ndarray:
    """Jaws wide open over the middle of what stands out of the table, across its longer side."""
    depth = observation["depth"]
    table = np.median(depth[depth > 0])
    rows, columns = np.nonzero((depth > 0) & (depth < table - 0.008))
    points = np.column_stack([columns, rows]).astype(float)
    centre = points.mean(0)
    short = np.linalg.eigh(np.cov((points - centre).T))[1][:, 0]
    angle = np.arctan2(-short[1], short[0])
    x, y = 2 * (centre + 0.5) / len(depth) - 1
    return np.array([x, y, np.sin(2 * angle), np.cos(2 * angle), 0.6], np.float32)


def main(episodes: int = 5) -> None:
    env = gymnasium.make("grasp_bench/Grasp-v0", objects="mug,banana,hammer")
    env.action_space.seed(0)
    for name, policy in (("random", lambda _: env.action_space.sample()), ("looking", look)):
        total = 0.0
        for episode in range(episodes):
            observation, _ = env.reset(seed=episode)
            *_, info = env.step(policy(observation))
            total += info["success"]
        print(f"{name}: {total:.0f} of {episodes} lifted")


if __name__ == "__main__":
    main()
