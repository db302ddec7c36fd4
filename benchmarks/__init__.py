"""What accuracy costs in time, measured: `python -m benchmarks`."""
