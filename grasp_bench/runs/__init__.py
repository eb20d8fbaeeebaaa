"""Runs without a simulator: records, folders, differences, statistics."""
