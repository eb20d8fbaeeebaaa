"""Grasp networks: a module for each architecture, a registration in :mod:`grasp_bench.networks.registry`.

All map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ and width in units of ``WIDTH_SCALE`` pixels,
at the resolution of the input.
"""
