"""What every node shares: spinning, parameters, quality of service, typed message builders, clocks, stamp checks."""
