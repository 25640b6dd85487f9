"""What a process settles with ROS and its middleware before anything of them is made."""

from er_ros_common import dds, log_place


def settle() -> None:
    """Our settings of the middleware, and a place for ROS's log files.

    Raises:
        InputError: The user named a place for the log files, and nothing can be written there.
    """
    dds.settle()
    log_place.settle()
