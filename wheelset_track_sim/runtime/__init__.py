"""What models and kernels need of the machine: caches, compiled functions, one core, memory."""
