"""Is this machine, run, predictor or physics fit?"""
