"""Pure models of semi-active dampers and quarter cars: no ROS, no plots, no clock."""
