"""Files for the tools of a vehicle stack, made from the tables of topics: recording, plots, names."""
