"""Sensors: where they are, what they read of the models, and what they make of it."""
