"""Objects of one's own: meshes, scans and robot descriptions turned into benchmark objects."""
