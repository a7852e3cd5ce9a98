"""The ROS 2 shell: node and message conversion. Nothing outside this package imports ROS."""
