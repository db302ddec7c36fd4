"""Periodic response: sub-intervals, collocation and harmonic balance."""
