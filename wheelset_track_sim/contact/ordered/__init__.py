"""The contact solver that goes on from the solution of the step before."""
