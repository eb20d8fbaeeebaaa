"""Robot, table, objects and camera in MuJoCo."""
