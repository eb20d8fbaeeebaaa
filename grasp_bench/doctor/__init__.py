"""Self-checks: is this machine fit to measure, and does a finished run repeat on it?"""
