"""Static and quasi-static response."""
