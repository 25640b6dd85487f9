"""Studies: the thesis's tables made again, benchmarks, comparisons, importers of measured data sets."""
