"""Motion: inverse kinematics, trajectories, and the plan of a grasp."""
