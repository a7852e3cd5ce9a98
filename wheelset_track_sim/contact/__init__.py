"""Wheel-rail normal contact: influence coefficients, Kalker's variational method, Hertz, force tables."""
