"""How the trials of a run are carried out: here, on worker processes, or on a cluster."""
