"""Why trials failed: each done again with one cause removed at a time."""
