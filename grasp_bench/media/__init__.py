"""Pictures and clips of trials: recorded while a run goes on, or made again from its records."""
