"""Execution of the trials of a run: in this process, on worker processes, or on a cluster."""
