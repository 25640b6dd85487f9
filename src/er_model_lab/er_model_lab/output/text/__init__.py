"""Words, units, order and pens that terminal and report share."""
