"""How wheelset and track answer to contact forces: one interface, three forms of it, and Green's functions."""
