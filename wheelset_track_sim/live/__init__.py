"""A run as a stream, without ROS: pace, changes, what is watched and recorded."""
