"""Meshes, scans and robot descriptions turned into benchmark objects."""
