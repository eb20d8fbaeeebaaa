"""Stages of synthetic scenes: how their camera, surroundings, depth and colour are drawn at random."""
