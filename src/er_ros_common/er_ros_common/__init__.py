"""What every node shares: spinning, declared parameters, quality of service, builders, clocks, health."""
