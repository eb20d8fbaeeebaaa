"""Pictures, films and recordings of trials."""
