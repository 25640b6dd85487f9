"""What the lab costs: a minute, more data, more effects."""
