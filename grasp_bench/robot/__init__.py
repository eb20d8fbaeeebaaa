"""The arm and its gripper: facts, kinematics and trajectories."""
