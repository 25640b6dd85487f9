"""What the columns of somebody's files probably are: looked at, guessed by name, unit and physics, written down."""
