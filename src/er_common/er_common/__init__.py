"""What the packages share without ROS: tables of parameters, checks of stamps, names of topics, wrong usage."""
