"""The coupled step, its dynamics, and the blocks of samples that it yields."""
