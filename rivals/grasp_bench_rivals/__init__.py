"""Weights that are too large for grasp-bench itself; it finds them in the folder ``weights`` beside this."""
