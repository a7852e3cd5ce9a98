"""The interactive page: what its controls say, the passages that answer them, and the server that shows both."""
