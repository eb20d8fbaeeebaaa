"""A recorded trial done again, to be looked at."""
