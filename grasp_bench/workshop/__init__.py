"""Makes the assets that trials use; no trial imports it."""
