"""Training of grasp networks on folders of synthetic scenes."""
