"""Data to train on: generated scenes of random shapes."""
