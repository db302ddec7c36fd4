"""Curves over a cycle through values at even positions of it, and where they are largest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array, norms

DRAWN = 360  # positions of a cycle, in so many at least curves are drawn
SMOOTH = 1e-3  # of the largest curve: a curve that its harmonics foretell to it has no corners that show
FADING = 0.2  # ratio of the last quarter of the harmonics to the one before, below which they fade
STRAIGHT = 1e-9  # of the largest turn of curves: where they turn less, Akima's curves are straight on both sides
NEIGHBOURS = 4  # positions beyond the ends of a cycle, to which a curve of Akima goes on


@dataclass(frozen=True, eq=False)
class CycleCurves:
    """Curves over a cycle, a cubic between every two points that are neighbours."""

    values: Array  # values at even points of the cycle, ``(points, ...)``
    slopes: Array  # slopes there, over the distance of two points, ``(points, ...)``
    # which curves are those of Akima, ``(...)``; None where they are nowhere beyond the positions beside them
    corners: Array | None = None
    per_position: int = 1  # points for each position that the curves were drawn through
    of_harmonics: bool = True  # whether curves without corners are those of their harmonics; else they are splines

    @classmethod
    def through(cls, values: Array, of_harmonics: bool = True, largest: float | None = None) -> CycleCurves:
        """Draw curves through values: by their harmonics or a spline, or where a curve has corners, that of Akima."""
        # Where positions are few, the harmonics that they show give values between them, through which cubic splines
        # go.
        # values: values at the positions, ``(positions, ...)``
        corners = cornered(values.reshape(len(values), -1), of_harmonics, largest).reshape(values.shape[1:])
        return cls._of_kinds(values, corners, of_harmonics)

    @classmethod
    def of_positions(cls, values: Array) -> CycleCurves:
        """Draw curves that are nowhere beyond the positions beside them, for what jumps between these."""
        # values: values at the positions, ``(positions, ...)``
        return cls(values, np.zeros(values.shape))

    @classmethod
    def _of_kinds(cls, values: Array, corners: Array, of_harmonics: bool) -> CycleCurves:
        """Draw curves through values, ``(positions, ...)``: those with corners, ``(...)``, by Akima."""
        times = -(-DRAWN // len(values))
        found, slopes = np.empty((2, times * len(values), *values.shape[1:]))
        smooth = _by_harmonics if of_harmonics else _by_splines
        for of_kind, which in ((smooth, ~corners), (_by_akima, corners)):
            if which.any():
                found[:, which], slopes[:, which] = of_kind(values[:, which], times)
        return cls(found, slopes, corners, times, of_harmonics)

    def others(self) -> CycleCurves:
        """Draw other curves through the same positions, by which it is judged how certain these are."""
        # They are curves of the same kinds through every second position, once the even ones and once the odd ones.
        # Of an odd number of positions, which has no halves, the curves give values at one more. They stand along a
        # second axis of the values, ``(positions, 2, ...)``.
        values = self.values[:: self.per_position]
        if len(values) % 2 and self.corners is not None:
            values = self._at_one_more()
        even, odd = np.arange(0, len(values), 2), np.arange(1, len(values), 2)
        if self.corners is None:
            odd = np.append(odd, odd[-1:])[: len(even)]  # of an odd number the last is there twice
            return self.of_positions(values[np.stack([even, odd], axis=1)])
        halves = values[np.stack([even, odd], axis=1)]
        return self._of_kinds(halves, np.stack([self.corners, self.corners]), self.of_harmonics)

    def _at_one_more(self) -> Array:
        """Give the values at one more even place than there are positions, ``(places, ...)``."""
        count = len(self.values) // self.per_position
        return self.at(np.arange(count + 1) * count / (count + 1))

    def at(self, places: Array) -> Array:
        """Give the values at some places, ``(places, ...)``."""
        # places: places in the cycle, where positions are 0, 1, 2 ..., ``(places,)``
        places = places * self.per_position
        k = np.floor(places).astype(int)
        found = self.values[k % len(self.values)]
        between = places > k
        k, f = k[between], (places - k)[between].reshape(-1, *(1 for _ in self.values.shape[1:]))
        ends = k % len(self.values), (k + 1) % len(self.values)
        found[between] = _cubic(f, *(part[at] for part in (self.values, self.slopes) for at in ends))
        return found

    def lengths(self) -> CycleCurves:
        """Give the lengths of vectors, whose components are the last dimension, by their values and slopes."""
        size = norms(self.values)
        along = (self.values * self.slopes).sum(axis=-1)
        slopes = np.divide(along, size, out=np.zeros(size.shape), where=size > 0)
        return replace(
            self, values=size, slopes=slopes, corners=None if self.corners is None else self.corners.any(axis=-1)
        )

    def highest(self) -> tuple[Array, Array]:
        """Give where each curve is highest, in positions, and how high it is there, ``(...)`` each."""
        # That is at a position, or between two of them where the slope of the cubic, a parabola, is zero.
        return self._farthest(1.0)

    def lowest(self) -> tuple[Array, Array]:
        """Give where each curve is lowest, in positions, and its value there, ``(...)`` each."""
        return self._farthest(-1.0)

    def largest(self) -> tuple[Array, Array]:
        """Give where the size of each curve is largest, in positions, and its value there, ``(...)`` each."""
        (above, high), (below, low) = self.highest(), self.lowest()
        down = -low > high
        return np.where(down, below, above), np.where(down, low, high)

    def longest(self) -> tuple[Array, Array]:
        """Give where vectors, whose components are the last dimension, are longest, in positions, and their lengths."""
        places, shape = self.lengths().highest()[0], self.values.shape[1:]
        along = np.broadcast_to(self.per_position * places[..., None], shape).ravel()
        k, which = np.floor(along).astype(int), np.arange(along.size)
        ends = [(at % len(self.values), which) for at in (k, k + 1)]
        parts = (part.reshape(len(part), -1) for part in (self.values, self.slopes))
        vectors = _cubic(along - k, *(part[at] for part in parts for at in ends)).reshape(shape)
        return places, norms(vectors)

    def _farthest(self, sign: float) -> tuple[Array, Array]:
        """Give where each curve is highest, or with -1 lowest, and its value there."""
        count, shape = len(self.values), self.values.shape[1:]
        v, s = (sign * part.reshape(count, -1) for part in (self.values, self.slopes))
        k, which = v.argmax(axis=0), np.arange(v.shape[1])
        places, highest = k.astype(float), v[k, which]
        reach = v + np.abs(s) / 3  # Bezier's points beside a position, below the higher of which a cubic stays
        k, which = np.nonzero(reach > highest)
        k, which = np.concatenate([k, k - 1]) % count, np.tile(which, 2)
        f, top = _top(v[k, which], v[(k + 1) % count, which], s[k, which], s[(k + 1) % count, which])
        np.maximum.at(highest, which, top)
        reached = top == highest[which]
        places[which[reached]] = ((k + f) % count)[reached]  # the end of a cycle is its start
        return places.reshape(shape) / self.per_position, sign * highest.reshape(shape)

    def turning(self) -> Array:
        """Give the values at the points and where the curves turn between them, in order."""
        # Gives three values for each point, ``(3 points, ...)``. What turns nowhere before the next repeats a value.
        v, w, s, t = self.values, np.roll(self.values, -1, axis=0), self.slopes, np.roll(self.slopes, -1, axis=0)
        (f, top), (g, bottom) = _top(v, w, s, t), _top(-v, -w, -s, -t)
        first = np.where(f < g, top, -bottom)
        return np.stack([v, first, np.where(f < g, -bottom, top)], axis=1).reshape(-1, *v.shape[1:])


def _slope(f: Array, v: Array, w: Array, s: Array, t: Array) -> Array:
    """Give the slopes at f of the cubics that `_cubic` gives."""
    return np.asarray(6 * f * (1 - f) * (w - v) + (1 - f) * (1 - 3 * f) * s + f * (3 * f - 2) * t)


def _top(v: Array, w: Array, s: Array, t: Array) -> tuple[Array, Array]:
    """Give where cubics over 0..1 are at a local maximum, and its value; the higher end where there is none inside."""
    a, b = 3 * (2 * (v - w) + s + t), 3 * (w - v) - 2 * s - t  # of the slope a f^2 + 2 b f + s
    root = np.sqrt(np.maximum(b**2 - a * s, 0.0))
    # where it falls through zero, f = -(b + root)/a = s/(root - b), by the form that cancels nothing
    over, under = np.where(b > 0, -(b + root), s), np.where(b > 0, a, root - b)
    f = np.divide(over, under, out=np.zeros(np.shape(v)), where=under != 0)
    inside = (f > 0) & (f < 1) & (root > 0)
    f = np.where(inside, f, np.where(w > v, 1.0, 0.0))
    return f, _cubic(f, v, w, s, t)


def _cubic(f: Array, v: Array, w: Array, s: Array, t: Array) -> Array:
    """Give the values at f of cubics over 0..1 with values v and w and slopes s and t at its ends (Hermite)."""
    g = 1 - f
    return np.asarray((1 + 2 * f) * g**2 * v + (1 + 2 * g) * f**2 * w + f * g * (g * s - f * t))


def _by_harmonics(values: Array, times: int) -> tuple[Array, Array]:
    """Give values of the harmonics of positions at so many times as many points, and slopes of splines there."""
    # The error falls with the positions as fast as the harmonics do; that of a spline falls with their fourth power.
    # values: values at the positions, ``(positions, curves)``
    found = _of_harmonics(values, times) if times > 1 else values
    return found, _spline_slopes(found)


def _of_harmonics(values: Array, times: int) -> Array:
    """Give values of the harmonics that positions show, at so many times as many points, ``(points, curves)``."""
    count, amplitudes = len(values), np.fft.rfft(values, axis=0)
    if count % 2 == 0:
        amplitudes[-1] /= 2  # of what positions show of it, half is that of the negative frequency
    found = np.fft.irfft(times * amplitudes, times * count, axis=0)
    found[::times] = values
    return np.asarray(found)


def _by_splines(values: Array, times: int) -> tuple[Array, Array]:
    """Give values and slopes of splines at so many times as many points; parameters as of `_by_harmonics`."""
    return _at_points(values, _spline_slopes(values), times)


def _by_akima(values: Array, times: int) -> tuple[Array, Array]:
    """Give values and slopes of Akima's curves at so many times as many points; parameters as of `_by_harmonics`."""
    return _at_points(values, _akima_slopes(values), times)


def _at_points(values: Array, slopes: Array, times: int) -> tuple[Array, Array]:
    """Give values and slopes of cubics at so many times as many points, ``(points, curves)`` each."""
    if times == 1:
        return values, slopes
    f = (np.arange(times) / times)[:, None, None]
    ends = values, np.roll(values, -1, axis=0), slopes, np.roll(slopes, -1, axis=0)
    shape = times * len(values), values.shape[1]
    found = [np.moveaxis(part(f, *ends), 0, 1).reshape(shape) for part in (_cubic, _slope)]
    return found[0], found[1] / times


def _spline_slopes(values: Array) -> Array:
    """Give slopes of cubic splines over a cycle, ``(positions, curves)``, by B-splines (Unser, 1999)."""
    from scipy.ndimage import spline_filter1d  # noqa: PLC0415  (slow to import)

    part = spline_filter1d(values, order=3, axis=0, mode="grid-wrap")
    return np.asarray(np.roll(part, -1, axis=0) - np.roll(part, 1, axis=0)) / 2


def _akima_slopes(values: Array) -> Array:
    """Give slopes of Akima's curves over a cycle, ``(positions, curves)`` (J. ACM 17, 1970, equation 1)."""
    # SciPy's are the same to the last bit, and take 0.07 s to import.
    after = np.roll(values, -1, axis=0) - values  # m3
    before = np.roll(after, 1, axis=0)  # m2
    turns = np.abs(after - before)
    of_before, of_after = np.roll(turns, -1, axis=0), np.roll(turns, 1, axis=0)  # |m4 - m3|, |m2 - m1|
    weights = of_before + of_after
    bent = weights > STRAIGHT * weights.max(initial=0.0)
    straight = 0.5 * (np.roll(after, -1, axis=0) + np.roll(before, 1, axis=0))  # on both sides: (m1 + m4)/2
    return np.divide(of_before * before + of_after * after, weights, out=straight, where=bent)


def akima_over_cycle(at: Array, values: Array, period: float, neighbours: int) -> Callable[..., Array]:
    """Give Akima's curves through values over a cycle, which do not swing beyond them at corners."""
    # at: ascending places of the values in the cycle, ``(places,)``; values: values there, ``(places, ...)``
    from scipy.interpolate import Akima1DInterpolator  # noqa: PLC0415  (slow to import)

    turns, which = np.divmod(np.arange(-neighbours, len(at) + neighbours), len(at))
    curve = Akima1DInterpolator(at[which] + period * turns, values[which])
    return lambda places, order=0: np.asarray(curve(places, order))


def cornered(values: Array, of_harmonics: bool = True, largest: float | None = None) -> Array:
    """Say which curves, ``(curves,)``, Akima's interpolant foretells better at positions left out."""
    # Of an odd number of positions, where not every second one can be left out, the other kind gives values at one
    # more.
    # values: values at the positions, ``(positions, curves)``
    if len(values) % 2:
        values = _at_one_more(values, of_harmonics)
    smooth = _missed(_of_harmonics if of_harmonics else lambda half, times: _by_splines(half, times)[0], values)
    if largest is None:
        largest = np.linalg.norm(values, axis=0).max(initial=0.0)
    found = np.greater(smooth, SMOOTH * largest)
    if of_harmonics and found.any():
        found[found] = ~_fading(values[:, found])
    if found.any():
        found[found] = _missed(lambda half, times: _by_akima(half, times)[0], values[:, found]) < smooth[found]
    return found


def _at_one_more(values: Array, of_harmonics: bool) -> Array:
    """Give values of the harmonics, or of a spline, at one more even place than there are, ``(places, curves)``."""
    count = len(values)
    if of_harmonics:
        return np.asarray(np.fft.irfft(np.fft.rfft(values, axis=0), count + 1, axis=0) * ((count + 1) / count))
    return CycleCurves(values, _spline_slopes(values))._at_one_more()


def _fading(values: Array) -> Array:
    """Say which curves, ``(curves,)``, have harmonics that fade before the highest that the positions show."""
    # Half of the positions may miss such a curve, and all of them do not. At corners the ratio is 0.2 to 1.
    amplitudes, quarter = np.abs(np.fft.rfft(values, axis=0)), len(values) // 8
    before, last = (
        np.linalg.norm(amplitudes[part], axis=0)
        for part in np.split(np.arange(len(amplitudes)), [2 * quarter, 3 * quarter])[1:]
    )
    return np.asarray(last < FADING * before)


def _missed(points: Callable[[Array, int], Array], values: Array) -> Array:
    """By how much halves of the positions miss curves at the others, root of the sum of squares, ``(curves,)``."""
    even, odd = values[::2], values[1::2]
    missed = [points(even, 2)[1::2] - odd, points(odd, 2)[1::2] - np.roll(even, -1, axis=0)]
    return np.asarray(np.linalg.norm(np.concatenate(missed), axis=0))
