"""From loads to levels and metrics: what a monitoring stack is told of a run, without ROS."""
