"""How well predictors do on data sets, and the paper's tables measured again."""
