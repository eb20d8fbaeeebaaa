"""What a trial is: the sections of a scenario, its random streams, and the ways it can end."""

from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario

__all__ = ["Scenario", "load_scenario"]
