"""How a bag is written, without ROS: files, definitions, counts."""
