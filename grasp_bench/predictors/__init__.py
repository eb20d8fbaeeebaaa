"""Grasp predictors: what one is, how it is named and asked, and those that are shipped.

There are four ways in besides the shipped names: an entry point of an installed package (group
``grasp_bench.predictors``), ``module:Class``, the address of a server (``http://127.0.0.1:8000``),
and a command that starts one (``cmd: python my_server.py --port {port}``).
"""

from grasp_bench.predictors.names import load_predictor

__all__ = ["load_predictor"]
