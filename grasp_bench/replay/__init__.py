"""Trials done again from their records: verified, told, and shown."""
