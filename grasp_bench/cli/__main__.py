"""``python -m grasp_bench.cli`` is ``grasp-bench``."""

from grasp_bench.cli.app import main

main()
