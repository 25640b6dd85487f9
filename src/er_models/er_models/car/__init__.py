"""The whole car: a rigid body on four corners, each a quarter car of its own (`kernel.car`)."""
