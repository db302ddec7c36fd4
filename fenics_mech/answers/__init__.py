"""Answers to a scene of each kind: at rest, over a cycle, in time, repeated, of modes, of rigid links."""
