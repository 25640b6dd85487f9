"""Heat and ageing: effects that scale others as the damper works."""
