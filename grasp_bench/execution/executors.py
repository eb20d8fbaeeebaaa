"""The executors by name: worker processes of this machine, or a Ray cluster."""

from __future__ import annotations

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.execution.processes import Processes
from grasp_bench.execution.protocol import Executor
from grasp_bench.execution.ray_cluster import RayCluster
from grasp_bench.system.machine import usable_cores

EXECUTORS = ("process", "ray")


def make_executor(
    name: str, workers: int, *, memory_limit: int | None = None, ray_address: str | None = None
) -> Executor:
    """Return an executor by name.

    Args:
        name: one of :data:`EXECUTORS`.
        workers: trials at a time; 0 takes one for each core.
        memory_limit: most memory of a worker [bytes]; by default its share of 80 % of the machine's.
        ray_address: address of a running cluster; without one, Ray is started on this machine.

    Raises:
        UnknownNameError: for an unknown name.
        GraspBenchError: when Ray is wanted and not installed, or an address given without it.
    """
    if name == "process":
        if ray_address is not None:
            raise GraspBenchError("--ray-address needs --executor ray.")
        return Processes(workers or usable_cores(), memory_limit)
    if name == "ray":
        return RayCluster(workers, ray_address, memory_limit)
    raise UnknownNameError("executor", name, EXECUTORS)
