"""What an analysis decides before it runs: effects, mesh, steps and stations."""
