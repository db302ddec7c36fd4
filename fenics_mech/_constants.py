"""Constants of mathematics, of units and of the machine, each with its one name."""

import math
import sys

TURN = 2 * math.pi  # rad, which is also one cycle of a drive angle
MILLI = 1e3  # mm in 1 m
MEGA = 1e-6  # MPa in a Pa
TINY = sys.float_info.min  # smallest number of full precision: keeps a denominator from being zero
ROUNDING = 1e-9  # of the largest number that is shown, up to which another is none
INTERRUPTED = 130  # exit code of a command that was interrupted, as a shell gives it
