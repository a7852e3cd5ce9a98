"""MCAP files: written, and read without trust."""
