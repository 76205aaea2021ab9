"""The definitions of docs/analysis.md once more, in NumPy, SciPy and statsmodels: written from that page, not from the program."""

import numpy as np
import statsmodels.api as sm
from scipy.integrate import trapezoid
from scipy.stats import t as student

# The interval of a fit to one recording: Newey–West with a tenth of it as lags, Student's t with 9 degrees of freedom.
LAGS_SHARE = 10
DEGREES = 9
# Half of a stretch of the plant's fit, s, and the exponent of its weights (1 − s²)ᵖ.
HALF_S = 0.1
POWER = 5


def robust(y, *columns):
    """Least squares on a constant and `columns`, with Newey–West standard errors: the fit of statsmodels."""
    x = np.column_stack([np.ones(len(y)), *columns])
    return sm.OLS(y, x).fit(cov_type="HAC", cov_kwds={"maxlags": len(y) // LAGS_SHARE})


def half_width(std_error):
    """Half of a 95 % interval."""
    return student.ppf(0.975, DEGREES) * std_error


def interval(estimate, std_error):
    """Estimate and the ends of its 95 % interval."""
    return estimate, estimate - half_width(std_error), estimate + half_width(std_error)


def phases(x, v, onset, offset):
    """Indices of onset, reversal and end of the movement."""
    fast = np.flatnonzero(np.abs(v) > onset)
    slow = np.flatnonzero(np.abs(v[fast[-1] :]) < offset)
    first, last = fast[0], fast[-1] + slow[0] if len(slow) else len(v) - 1
    return first, first + int(np.argmax(x[first : last + 1])), last


def farthest(x, f, beyond=-np.inf):
    """Of a way towards larger x, the samples that lie farther along than any before, and than where it begins."""
    before = np.concatenate([[beyond], np.maximum(beyond, np.maximum.accumulate(x)[:-1])])
    return x[x > before], f[x > before]


def discrepancy(x, f, first, turn, last, points, lever):
    """Mean, largest, step and loop area, with the intervals of those that have one."""
    way_in = farthest(x[first : turn + 1], f[first : turn + 1])
    way_out = farthest(-x[turn + 1 : last + 1], f[turn + 1 : last + 1], beyond=-x[turn])
    low, high = max(way_in[0][0], -way_out[0][-1]), min(way_in[0][-1], -way_out[0][0])
    grid = np.linspace(low, high, points)
    d = np.interp(grid, *way_in) - np.interp(grid, -way_out[0][::-1], way_out[1][::-1])
    tenth = slice(-((points - 1) // 10) - 1, None)
    error = robust(d, grid - (low + high) / 2).bse[0]
    step = robust(d[tenth], grid[tenth] - x[turn])
    path = slice(first, last + 1)
    closed = np.append(x[path], x[first]), np.append(f[path], f[first])
    return {
        "discrepancy_user_mean": interval(trapezoid(d, grid) / (high - low), error),
        "discrepancy_user_max": (d.max(),),
        "discrepancy_user_step": interval(step.params[0], step.bse[0]),
        "loop_area": interval(lever * trapezoid(closed[1], closed[0]), lever * (high - low) * error),
    }


def spring(x, f, command, first, turn, last, rest, past_rest):
    """Slope, its standard error and interval, force at rest, R², samples, RMS error and returned energy of a spring that
    does not saturate."""
    press = np.arange(first, turn + 1)
    press = press[x[press] - rest >= past_rest]
    fit = robust(f[press], x[press] - rest)
    given_back = -trapezoid(f[turn : last + 1], x[turn : last + 1])
    return {
        "stiffness": interval(fit.params[1], fit.bse[1]),
        "stiffness_std_error": (fit.bse[1],),
        "force_at_rest": (fit.params[0],),
        "stiffness_r2": (fit.rsquared,),
        "stiffness_samples": (len(press),),
        "force_rms_error": (np.sqrt(np.mean((f[press] - command[press]) ** 2)),),
        "returned_energy_share": (given_back / trapezoid(f[first : turn + 1], x[first : turn + 1]),),
    }


def plant(t, theta, velocity, torque, onset):
    """The fit of offset, inertia, damping, dry friction and stiffness to the slipping stretches of an evenly sampled recording."""
    rows = [row for i in range(len(t)) if (row := stretch(t, theta, velocity, torque, i, onset))]
    y, *columns = np.array(rows).T
    return robust(y, *columns)


def stretch(t, theta, velocity, torque, i, onset):
    """Averages of torque, θ̈, θ̇, sgn θ̇ and θ about sample i; None where it is not covered or does not slip one way."""
    step = (t[-1] - t[0]) / (len(t) - 1)
    reach = round(HALF_S / step)
    if i < reach or i + reach >= len(t):
        return None
    inside = slice(i - reach + 1, i + reach)
    sign = np.sign(velocity[i])
    if np.any(sign * velocity[inside] < onset):
        return None
    phi = np.polynomial.Polynomial([1, 0, -1]) ** POWER
    s = (t[inside] - t[i]) / HALF_S
    weight, slope, curvature = phi(s), phi.deriv(1)(s) / HALF_S, phi.deriv(2)(s) / HALF_S**2
    mean = lambda w, y: np.dot(w, y[inside]) / weight.sum()
    return mean(weight, torque), mean(curvature, theta), -mean(slope, theta), sign, mean(weight, theta)
