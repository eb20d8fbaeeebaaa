"""The gate: did the success rate of a new run drop below that of an old one?"""
