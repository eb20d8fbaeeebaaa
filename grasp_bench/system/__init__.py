"""Files, paths, processes, graphics and the machine."""
