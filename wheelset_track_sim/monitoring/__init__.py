"""Levels and metrics of loads for monitoring stacks, without ROS."""
