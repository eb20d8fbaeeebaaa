"""A run done in parts on several machines, put together again."""
