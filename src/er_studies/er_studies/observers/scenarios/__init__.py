"""Named, seeded drives that observers are compared on, and how wrong each thing in them is."""
