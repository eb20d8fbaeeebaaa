"""Objects: authoring, decomposition, catalog and import."""
