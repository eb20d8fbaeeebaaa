"""Data sets, training, and the rectangle metric."""
