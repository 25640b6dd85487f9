"""Tables of `docs/results` that are made from the JSON a command wrote, and kept beside it in `docs/results/data`."""
