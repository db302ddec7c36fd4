"""The elastic response of a mechanism: static, periodic or in time, and whether it is stable."""
