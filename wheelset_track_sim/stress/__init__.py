"""Axle stresses: six components and principal stresses."""
