"""How much of the data is searched: all, or stretches of long data, and what then holds on all of them."""
