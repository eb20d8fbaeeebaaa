"""Grasp networks: a module for each architecture, a registration in :mod:`grasp_bench.networks.registry`.

Most map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ and width in units of ``WIDTH_SCALE`` pixels,
at the resolution of the input. A :class:`grasp_bench.networks.rows.Detector` maps it to rows (B, N, 6), a
grasp each with its score, and has its own loss. Entries are in :mod:`grasp_bench.networks.entries`.
"""
