"""A predictor in a process of its own, without grasp-bench: NumPy and Python's own HTTP server.

Any Python, framework or GPU may be here; docs/predictors.md describes what is sent. Let the harness
start it,

    cd examples
    grasp-bench run --trials 20 --predictor 'cmd: python 06_server.py --port {port}'

or start it yourself and give --predictor http://127.0.0.1:8000. It lifts 18 of 20.
"""

import argparse
import io
import json
from http.server import BaseHTTPRequestHandler, HTTPServer

import numpy as np


def predict(rgb: np.ndarray, depth: np.ndarray, K: np.ndarray, rng: np.random.Generator) -> list[dict]:
    """The middle of what stands out, jaws open to 80 mm across its longer axis."""
    if not depth.any():
        return []
    table = np.median(depth[depth > 0])
    rows, columns = np.nonzero((depth > 0) & (depth < table - 0.01))
    if len(rows) < 20:
        return []
    _, axes = np.linalg.eigh(np.cov(columns, rows))
    dx, dy = axes[:, 0]  # the shorter axis comes first
    opening = 0.08 * K[0, 0] / np.median(depth[rows, columns])  # metres to pixels
    return [
        {
            "x": columns.mean() + 0.5,
            "y": rows.mean() + 0.5,
            "angle": np.arctan2(-dy, dx),
            "width": opening,
            "quality": 0.5,
        }
    ]


class Handler(BaseHTTPRequestHandler):
    def do_GET(self) -> None:  # /info: "protocol" is needed, the rest identifies the predictor
        self.answer(200, {"protocol": 1, "predictor": "middle of what stands out", "version": "1"})

    def do_POST(self) -> None:  # /predict
        body = self.rfile.read(int(self.headers["Content-Length"]))
        try:
            sent = np.load(io.BytesIO(body), allow_pickle=False)
            rng = np.random.default_rng(sent["seed"])  # the same trial, the same numbers
            grasps = predict(sent["rgb"], sent["depth"], sent["K"], rng)
            self.answer(200, {"grasps": [{k: float(v) for k, v in g.items()} for g in grasps]})
        except Exception as error:
            self.answer(500, {"error": f"{type(error).__name__}: {error}"})

    def answer(self, status: int, content: dict) -> None:
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
    HTTPServer(("127.0.0.1", parser.parse_args().port), Handler).serve_forever()
