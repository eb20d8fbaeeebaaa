"""``python -m grasp_bench.cli`` is ``grasp-bench``."""

from grasp_bench.cli.start import main

main()
