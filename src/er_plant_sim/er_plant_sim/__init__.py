"""A quarter car with a semi-active damper as a ROS 2 node."""
