"""What comes out of a run: blocks of samples, and what is derived from them."""
