"""Robot, camera and object in one simulated scene."""
