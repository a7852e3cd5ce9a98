"""Runs as MCAP bags: written and read without ROS."""
