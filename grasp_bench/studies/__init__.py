"""Many runs put side by side: the table of all predictors, and sweeps of a parameter."""
