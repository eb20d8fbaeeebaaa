"""Reports: Table 4 of the paper beside the runs of this benchmark."""
