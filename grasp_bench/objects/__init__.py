"""The objects to be grasped, as they are shipped."""
