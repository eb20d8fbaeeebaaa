"""From what the camera saw to a motion of the arm."""
