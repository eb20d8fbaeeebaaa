"""Self-checks of the machine, a run, a predictor and the physics."""
