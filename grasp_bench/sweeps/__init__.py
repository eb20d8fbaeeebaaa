"""Success against a parameter of the scenario; see :mod:`grasp_bench.sweeps.study`."""
