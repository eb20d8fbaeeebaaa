"""A network for grasps in six degrees of freedom, behind HTTP in its own environment: NumPy and Python only.

Contact-GraspNet, AnyGrasp and their like need CUDA and a Python of their own. Put this file there; the
weights stay theirs. --network names a function that takes points (N, 3) [m], colours (N, 3) and intrinsics
(3, 3), and returns poses (M, 4, 4) in the camera's frame, openings (M,) [m] and scores (M,), with the axes
that --axes says (ours, contact-graspnet or graspnet):

    cd examples
    grasp-bench predictors check 'cmd: python 09_pose_server.py --port {port}'
    grasp-bench run --trials 20 --predictor 'cmd: python 09_pose_server.py --port {port}'

and with a network, --predictor 'cmd: its-python 09_pose_server.py --network my_net:run --port {port}'.
Without one it answers with what geometry alone says: the middle of what stands out, from above. That
lifts 15 of 20.
"""

import argparse
import importlib
import io
import json
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, HTTPServer

import numpy as np

# Columns of the network's rotation that are our x (jaws), y and z (approach), and how far the finger tips are
# beyond its origin along the approach [m]. GraspNet's networks give that depth with each grasp: add it there.
AXES = {
    "ours": ([0, 1, 2], 0.0),
    "contact-graspnet": ([0, 1, 2], 0.1034),  # the Panda's hand: z approach, x jaws
    "graspnet": ([1, 2, 0], 0.02),  # x approach, y jaws
}


def from_above(points: np.ndarray, colours: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, ...]:
    """The middle of what stands out of a table seen from above, jaws across it: no network at all."""
    high = points[points[:, 2] < np.median(points[:, 2]) - 0.01]
    if len(high) < 20:
        return np.zeros((0, 4, 4)), np.zeros(0), np.zeros(0)
    _, axes = np.linalg.eigh(np.cov(high[:, 0], high[:, 1]))
    x, z = np.array([*axes[:, 0], 0.0]), np.array([0.0, 0.0, 1.0])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    lowest = np.percentile(points[:, 2], 90) - 0.004
    pose[:3, 3] = [*np.median(high[:, :2], axis=0), min(np.percentile(high[:, 2], 5) + 0.025, lowest)]
    return pose[None], np.array([0.08]), np.array([0.5])


def answer(sent: dict, network: Callable, axes: str, most: int = 100) -> list[dict]:
    """The grasps for one request, best first."""
    depth, K = sent["depth"], sent["K"]
    rows, columns = np.nonzero(depth)
    z = depth[rows, columns].astype(float)
    x, y = (columns + 0.5 - K[0, 2]) * z / K[0, 0], (rows + 0.5 - K[1, 2]) * z / K[1, 1]
    if len(z) == 0:
        return []
    poses, openings, scores = network(np.column_stack([x, y, z]), sent["rgb"][rows, columns], K)
    order, beyond = AXES[axes]
    grasps = []
    for i in np.argsort(-np.asarray(scores), kind="stable")[:most]:
        rotation = poses[i][:3, order]
        position = poses[i][:3, 3] + beyond * rotation[:, 2]
        grasps.append(
            {
                "position": position.tolist(),
                "rotation": rotation.tolist(),
                "opening": float(openings[i]),
                "quality": float(scores[i]),
            }
        )
    return grasps


class Handler(BaseHTTPRequestHandler):
    network: Callable = staticmethod(from_above)
    axes = "ours"
    name = "middle of what stands out, as a pose"

    def do_GET(self) -> None:  # /info: "protocol" is needed, the rest identifies the predictor
        self.reply(200, {"protocol": 2, "predictor": self.name, "axes": self.axes})

    def do_POST(self) -> None:  # /predict
        body = self.rfile.read(int(self.headers["Content-Length"]))
        try:
            sent = dict(np.load(io.BytesIO(body), allow_pickle=False))
            np.random.seed(
                int(sent["seed"][0] % 2**32)
            )  # for networks that draw points: the same trial, the same
            self.reply(200, {"grasps": answer(sent, self.network, self.axes)})
        except Exception as error:
            self.reply(500, {"error": f"{type(error).__name__}: {error}"})

    def reply(self, status: int, content: dict) -> None:
        body = json.dumps(content).encode()
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Not a line for every image."""


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=8000)
    parser.add_argument("--network", help="module:function; see above")
    parser.add_argument("--axes", choices=AXES, default="ours")
    told = parser.parse_args()
    Handler.axes = told.axes
    if told.network:
        module, _, function = told.network.partition(":")
        Handler.network = staticmethod(getattr(importlib.import_module(module), function))
        Handler.name = told.network
    HTTPServer(("127.0.0.1", told.port), Handler).serve_forever()
