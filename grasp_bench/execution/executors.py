"""Where trials are carried out: worker processes of this machine, or a Ray cluster."""

from __future__ import annotations

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.execution.here import Here
from grasp_bench.execution.protocol import Answer, Executor, Fault
from grasp_bench.system.machine import usable_cores

__all__ = ["EXECUTORS", "Answer", "Executor", "Fault", "Here", "make_executor"]

EXECUTORS = ("process", "ray")


def make_executor(
    name: str, workers: int, *, memory_limit: int | None = None, ray_address: str | None = None
) -> Executor:
    """An executor by name.

    Args:
        name: one of :data:`EXECUTORS`.
        workers: trials at a time; 0 takes one for each core.
        memory_limit: of a worker [bytes]; by default its share of 80 % of the machine's.
        ray_address: of a running cluster; without one, Ray is started on this machine.

    Raises:
        UnknownNameError: for a name that is none of them.
        GraspBenchError: when Ray is wanted and not installed, or an address given without it.
    """
    if name == "process":
        if ray_address is not None:
            raise GraspBenchError("--ray-address needs --executor ray.")
        from grasp_bench.execution.processes import Processes

        return Processes(workers or usable_cores(), memory_limit)
    if name == "ray":
        from grasp_bench.execution.ray_cluster import RayCluster

        return RayCluster(workers, ray_address, memory_limit)
    raise UnknownNameError("executor", name, EXECUTORS)
