"""Bags played again: their messages as they were recorded, each at its time; without ROS, which only publishes them."""
