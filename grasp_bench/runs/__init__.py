"""What a run is, without a simulator: records, folders, differences, statistics."""
