"""Which runs may stand in one table, and that table."""
