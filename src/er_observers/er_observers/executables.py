"""Entry points of the package's nodes, light: see `er_ros_common.entry`."""

from er_ros_common.entry import program

unified_observer = program("er_observers.nodes.unified_observer")
nlpv_polytopic_observer = program("er_observers.nodes.nlpv_polytopic_observer")
nlpv_gridding_observer = program("er_observers.nodes.nlpv_gridding_observer")
fault_estimator = program("er_observers.nodes.fault_estimator")
