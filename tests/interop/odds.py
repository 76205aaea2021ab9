"""The cumulative-logit model of answers, one per participant and mode, with an effect of the participant.

P(y ≤ k) = F(θₖ − xβ − σu), F the logistic function, u standard normal; written from docs/analysis.md and Hedeker & Gibbons
(1994). u is integrated out by trapezoids so close that they are exact (the integrand is analytic, and nothing at both ends),
where the program places a few nodes around a mode.
"""

import numpy as np
from scipy import optimize, stats
from scipy.special import expit, log_expit, logsumexp

# u, its spacing, and the logarithm of a trapezoid's weight.
U = np.linspace(-8.5, 8.5, 171)
LOG_WEIGHT = stats.norm.logpdf(U) + np.log(U[1] - U[0])
# A maximum: slopes of the log-likelihood below this.
FLAT = 1e-8
# Newton's steps towards the end of an interval, and how close it then is.
STEPS, RESOLUTION = 30, 1e-9


class Model:
    """Answers by participant with columns of fixed effects; categories that nobody chose are left out."""

    def __init__(self, answers, people, columns):
        together = np.argsort(np.asarray(people), kind="stable")
        self.code = np.unique(answers, return_inverse=True)[1][together]
        self.people = np.unique(people, return_inverse=True)[1][together]
        self.first = np.flatnonzero(np.diff(self.people, prepend=-1))
        self.columns = np.asarray(columns, float).reshape(len(together), -1)[together]
        self.thresholds = self.code.max()

    def minus_log_likelihood(self, p):
        """It and its slopes at θ₁, the logarithms of the other thresholds' distances, β and σ."""
        q, n = self.thresholds, self.columns.shape[1]
        steps, beta, sd = np.exp(p[1:q]), p[q : q + n], p[-1]
        theta = np.concatenate([[-np.inf], p[0] + np.concatenate([[0], np.cumsum(steps)]), [np.inf]])
        eta = (self.columns @ beta)[:, None] + sd * U
        above, below = theta[self.code + 1][:, None] - eta, theta[self.code][:, None] - eta
        # F(a) − F(b) = F(a) (1 − F(b)) (1 − e^(b − a)).
        width = (theta[self.code + 1] - theta[self.code])[:, None]
        log_p = log_expit(above) + log_expit(-below) + np.log(-np.expm1(-width))
        joint = np.add.reduceat(log_p, self.first) + LOG_WEIGHT
        each = logsumexp(joint, axis=1)
        share = np.exp(joint - each[:, None])[self.people]
        # d ln P by the two thresholds of the answer.
        odds = 1 / np.expm1(width)
        by_above, by_below = expit(-above) + odds, -expit(below) - odds
        by_eta = -(expit(-above) - expit(below))
        mean = lambda slope: (share * slope).sum(axis=1)
        by_theta = np.bincount(self.code + 1, mean(by_above), q + 2) + np.bincount(self.code, mean(by_below), q + 2)
        lifted = np.cumsum(by_theta[1 : q + 1][::-1])[::-1]
        by_beta, by_sd = self.columns.T @ mean(by_eta), mean(by_eta * U).sum()
        slopes = np.concatenate([lifted[:1], lifted[1:] * steps, by_beta, [by_sd]])
        return -each.sum(), -slopes

    def fitted(self, start=None, held=None):
        """The maximum: parameters and log-likelihood. `held` is the number of a column and its coefficient."""
        q, n = self.thresholds, self.columns.shape[1]
        if start is None:
            cut = np.cumsum(np.bincount(self.code))[:-1] / len(self.code)
            theta = np.log(cut / (1 - cut))
            start = np.concatenate([theta[:1], np.log(np.diff(theta)), np.zeros(n), [1.0]])
        free = np.ones(len(start), bool)
        start = start.copy()
        if held:
            free[q + held[0]] = False
            start[q + held[0]] = held[1]

        def of_free(p):
            whole = start.copy()
            whole[free] = p
            value, slopes = self.minus_log_likelihood(whole)
            return value, slopes[free]

        found = optimize.minimize(of_free, start[free], jac=True, method="BFGS", options={"gtol": 1e-6}).x
        for _ in range(20):
            slopes = of_free(found)[1]
            if abs(slopes).max() < FLAT:
                break
            bend = np.array([(of_free(found + h)[1] - of_free(found - h)[1]) / 2e-5 for h in 1e-5 * np.eye(len(found))])
            found = found - np.linalg.solve((bend + bend.T) / 2, slopes)
        if abs(of_free(found)[1]).max() > FLAT:
            raise ArithmeticError(f"no maximum: slopes {of_free(found)[1]}")
        start[free] = found
        return start, -of_free(found)[0]

    def without(self, columns):
        """The same answers without some columns."""
        return Model(self.code, self.people, np.delete(self.columns, columns, axis=1))

    def profile_end(self, best, top, column, fall, sign):
        """The coefficient below (−1) or above (1) its estimate at which twice the log-likelihood has lost `fall`."""
        place = self.thresholds + column
        p, value = best, best[place] + sign
        for _ in range(STEPS):
            p, here = self.fitted(p, (column, value))
            # √ of the fall is nearly a straight line; its slope comes of the envelope theorem.
            root = np.sqrt(2 * (top - here))
            step = (np.sqrt(fall) - root) / (self.minus_log_likelihood(p)[1][place] / root)
            value += step
            if abs(step) < RESOLUTION:
                return value
        raise ArithmeticError(f"no end: last step {step}")


def against_reference(answers, people, modes, reference, others, level=0.95):
    """For each other mode the odds of a higher answer in the reference mode over those in it, for one person: ratio, ends of
    its profile interval and p value; then the p value of any difference. Likelihood ratios per column over F, with
    (participants − 1)(modes − 1) degrees of freedom."""
    model = Model(answers, people, [[float(m == other) for other in others] for m in modes])
    best, top = model.fitted()
    df = model.people.max() * len(others)
    ratio = lambda columns: 2 * (top - model.without(columns).fitted()[1]) / len(columns)
    rows = {}
    for column, other in enumerate(others):
        ends = [model.profile_end(best, top, column, stats.t.ppf((1 + level) / 2, df) ** 2, sign) for sign in (1, -1)]
        rows[other] = {
            "odds_ratio": np.exp(-best[model.thresholds + column]),
            "odds_ratio_ci_low": np.exp(-ends[0]),
            "odds_ratio_ci_high": np.exp(-ends[1]),
            "p_value": stats.f.sf(ratio([column]), 1, df),
        }
    return rows, stats.f.sf(ratio(list(range(len(others)))), len(others), df)
