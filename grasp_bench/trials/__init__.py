"""The spine: an attempt from settling to judging, its execution, and episodes of many."""
