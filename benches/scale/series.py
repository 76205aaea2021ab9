"""What needs a transform of each trial, in NumPy and FINUFFT: smoothness, and the bands of force and velocity.

Definitions: docs/analysis.md. FINUFFT takes Fourier sums at uneven times (Barnett, Magland & af Klinteberg 2019,
SIAM J. Sci. Comput. 41:C479).
"""

import finufft
import numpy as np

# Smoothness: up to so many Hz, and where the spectrum has so much of its value at 0 Hz; so much zero padding.
CUTOFF_HZ, AMPLITUDE, PADDING, LEAST_SAMPLES = 10.0, 0.05, 16, 3
# A way that is so short a share of the angles' range is no movement.
MOVEMENT_SHARE = 0.1
# A band: from and to, Hz; the overlap's step in segments of 1 s; ∫ w² dt of their window.
LOW_HZ, HIGH_HZ, LARGEST_HOP_S, HANN_POWER_S = 5, 50, 0.5, 3 / 8
COLUMNS = [
    "sparc_forward",
    "sparc_backward",
    "force_band_rms_n",
    "force_band_dominant_hz",
    "force_band_top_hz",
    "velocity_band_rms_rad_s",
    "velocity_band_dominant_hz",
    "velocity_band_top_hz",
]


def weights(t):
    """What each sample counts in ∫ y dt by the trapezoidal rule."""
    steps = np.diff(t) / 2
    return np.concatenate([[0.0], steps]) + np.concatenate([steps, [0.0]])


def squared(t, y, step_hz, count):
    """|∫ y e^(−2πift) dt|² at the frequencies f = k step, from 0 on."""
    at = 2 * np.pi * step_hz * (t - t[0])
    sums = finufft.nufft1d1(at, (weights(t) * y).astype(complex), 2 * count, eps=1e-14, isign=-1, nthreads=1)
    return np.abs(sums[count:]) ** 2


def smoothness(t, v):
    """Spectral arc length of a speed profile."""
    n = len(t)
    rate_hz = (n - 1) / (t[-1] - t[0]) if n >= LEAST_SAMPLES else 0.0
    if rate_hz < 2 * CUTOFF_HZ:
        return None
    step_hz = rate_hz / (PADDING * 2 ** int(np.ceil(np.log2(n))))
    power = squared(t, np.abs(v), step_hz, int(CUTOFF_HZ / step_hz) + 1)
    share = np.sqrt(power / power[0])
    last = np.flatnonzero(share >= AMPLITUDE)[-1]
    return -np.sqrt(1 / last**2 + np.diff(share[: last + 1]) ** 2).sum() if last > 0 else None


def windowed(t, y, begin):
    """Less its line, under the Hann window of the segment that begins there."""
    dt, dy = t - t.mean(), y - y.mean()
    return (dy - dt @ dy / (dt @ dt) * dt) * np.cos(np.pi * (t - begin - 0.5)) ** 2


def band(t, y):
    """Root mean square, dominant frequency and top of the band, by Welch's method."""
    nothing = (None, None, None)
    if len(t) < 2 or t[-1] - t[0] < 1.0:
        return nothing
    length = t[-1] - t[0]
    below = [f for f in range(LOW_HZ, HIGH_HZ + 1) if f < (len(t) - 1) / length / 2]
    if not below:
        return nothing
    top, hops = below[-1], int(np.ceil((length - 1.0) / LARGEST_HOP_S))
    power = np.zeros(top + 2)
    for segment in range(hops + 1):
        begin = t[0] + (segment * (length - 1.0) / hops if hops else 0.0)
        some = slice(np.searchsorted(t, begin), np.searchsorted(t, begin + 1.0, side="right"))
        power += squared(t[some], windowed(t[some], y[some], begin), 1.0, top + 2)
    power *= 2 / (HANN_POWER_S * (hops + 1))
    in_band = power[LOW_HZ : top + 1]
    if in_band.sum() <= 0:
        return nothing
    k = LOW_HZ + int(in_band.argmax())
    dominant = None
    if power[k] > power[k - 1]:
        ratio = np.sqrt(max(power[k - 1], power[k + 1]) / power[k])
        away = max((2 * ratio - 1) / (1 + ratio), 0.0)
        dominant = float(np.clip(k + away if power[k + 1] > power[k - 1] else k - away, LOW_HZ, top))
    return float(np.sqrt(in_band.sum())), dominant, float(top)


def of_trial(trial):
    """These columns of a trial: its samples, its phases, and the force sensor's own values."""
    t, x, v, taken, value, onset, reversal, end = trial
    moves = lambda a, b: abs(x[b] - x[a]) > MOVEMENT_SHARE * (x.max() - x.min())
    smooth = lambda a, b: smoothness(t[a : b + 1], v[a : b + 1]) if moves(a, b) else None
    some = slice(np.searchsorted(taken, t[onset]), np.searchsorted(taken, t[end], side="right"))
    force, velocity = band(taken[some], value[some]), band(t[onset : end + 1], v[onset : end + 1])
    return smooth(onset, reversal), smooth(reversal, end), *force, *velocity
