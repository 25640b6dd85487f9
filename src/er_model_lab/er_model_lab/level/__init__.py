"""What is predicted: the force of a damper from its motion, or all outputs of a car from its road."""
