"""What every node shares: spinning, parameters, quality of service, builders, clocks, stamps."""
