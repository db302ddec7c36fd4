"""Estimates of every error of a result, made from its solution."""
