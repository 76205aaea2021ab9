"""Kenward & Roger's degrees of freedom with 60 digits, from the definition, for the models of mixed_models.R.

    Rscript mixed_models.R 60 | python kenward_roger.py

From X, the random terms and the variances that lme4 found: V, P = V⁻¹ − V⁻¹ X Φ Xᵀ V⁻¹, W = 2 tr(P Gᵣ P Gₛ)⁻¹ and
A₁, A₂ of section 3 (Biometrics 53:983), as dense matrices and nothing else. For a single contrast A₁ = A₂ = A, for its
Θ Φ Pᵣ Φ have rank one, and the paper's formula comes to df = 2 / A: with q = 1, g = −1, c = (−1, 2, 4) / 7, B = 7 A / 2,
so ρ = (1 − A/2) / (1 − 2 A) times ((1 − A) / (1 − A))². Where A is 1 that last factor is 0/0, and pbkrtest shows what
rounding has left of it. Its limit is 1, so df is 2 there; and 1 / (1 − A), to which the paper sets the mean of F, has no
end just as the mean of F(1, df) has none from df = 2 downwards.

Every contrast with A near 1 is looked at, and a few of the others; fails where A₁ ≠ A₂, where pbkrtest's df is not 2 / A
though A is not 1, or where it is further from 2 than rounding explains.
"""

import decimal
import json
import sys
from decimal import Decimal

decimal.getcontext().prec = 60
OTHERS = 5  # models without such a contrast that are looked at too
MOST_ROWS = 60  # dense inverses in Python


def times(a, b):
    columns = list(zip(*b))
    return [[sum(x * y for x, y in zip(row, column)) for column in columns] for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def combined(a, b, scale):
    return [[x + scale * y for x, y in zip(p, q)] for p, q in zip(a, b)]


def inverse(a):
    """Gauss–Jordan with the largest pivot."""
    n = len(a)
    rows = [list(row) + [Decimal(int(i == j)) for j in range(n)] for i, row in enumerate(a)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for k in range(n):
            if k != i and rows[k][i]:
                factor = rows[k][i]
                rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i])]
    return [row[n:] for row in rows]


def trace_of_product(a, b):
    return sum(a[i][j] * b[j][i] for i in range(len(a)) for j in range(len(b)))


def covariances(case):
    """The matrices Gᵣ and their variances: a term's entries (a, b), and the residual's."""
    group, n = case["group"], len(case["response"])
    parts = []
    for term, found in zip(case["random"], case["found"]["covariances"]):
        block = list(zip(group, term["level"]))
        columns = [[Decimal(x) for x in (c * n if len(c) == 1 else c)] for c in term["columns"]]
        for a in range(len(columns)):
            for b in range(a + 1):
                def entry(i, j):
                    if block[i] != block[j]:
                        return Decimal(0)
                    once = columns[a][i] * columns[b][j]
                    return once if a == b else once + columns[b][i] * columns[a][j]
                parts.append(([[entry(i, j) for j in range(n)] for i in range(n)], Decimal(found[a][b])))
    identity = [[Decimal(int(i == j)) for j in range(n)] for i in range(n)]
    return parts + [(identity, Decimal(case["found"]["residual_variance"][0]))]


def moments(case):
    """A₁ and A₂ of each coefficient."""
    x = transposed([[Decimal(v) for v in column] for column in case["fixed"]])
    parts = covariances(case)
    n = len(x)
    v = [[sum(gamma * g[i][j] for g, gamma in parts) for j in range(n)] for i in range(n)]
    v_inverse = inverse(v)
    vx = times(v_inverse, x)
    phi = inverse(times(transposed(x), vx))
    projected = combined(v_inverse, times(vx, times(phi, transposed(vx))), Decimal(-1))
    pg = [times(projected, g) for g, _ in parts]
    information = [[trace_of_product(a, b) for b in pg] for a in pg]
    w = [[2 * entry for entry in row] for row in inverse(information)]
    p = [[[-entry for entry in row] for row in times(transposed(vx), times(g, vx))] for g, _ in parts]
    both = []
    for contrast in case["found"]["contrasts"]:
        l = [[Decimal(weight) for weight in contrast["weights"]]]
        variance = times(times(l, phi), transposed(l))[0][0]
        theta_phi = [[a * b / variance for b in times(l, phi)[0]] for a in l[0]]
        u = [times(theta_phi, times(part, phi)) for part in p]
        traces = [sum(part[i][i] for i in range(len(part))) for part in u]
        size = range(len(u))
        a1 = sum(w[r][s] * traces[r] * traces[s] for r in size for s in size)
        a2 = sum(w[r][s] * trace_of_product(u[r], u[s]) for r in size for s in size)
        both.append((a1, a2))
    return both


def main():
    looked, near, others, worst = 0, 0, 0, 0
    for case in json.load(sys.stdin):
        contrasts = case["found"].get("contrasts")
        if not contrasts or len(case["response"]) > MOST_ROWS:
            continue
        if not any(abs(contrast["kr_df"][0] - 2) < 0.05 for contrast in contrasts):
            if others == OTHERS:
                continue
            others += 1
        for contrast, (a1, a2) in zip(contrasts, moments(case)):
            theirs, df = contrast["kr_df"][0], 2 / a2
            where = f"{case['name']}: A₂ − 1 = {a2 - 1:.3e}, 2 / A {df:.12f}, pbkrtest {theirs:.12f}"
            assert abs(a1 / a2 - 1) < Decimal("1e-45"), f"{where}: A₁ {a1}"
            looked += 1
            # Rounding of 1e-15 or so beside 1 − A
            left = abs(float(1 - a2))
            error = abs(theirs / float(df) - 1)
            if left > 1e-3:
                worst = max(worst, error)
                assert error < 1e-8, where
            else:
                near += 1
                print(where)
                assert error < 0.05, where
    print(f"{looked} contrasts: A₁ = A₂ to 45 digits in all; {near} with A near 1; of the others pbkrtest's df is 2 / A "
          f"to {worst:.1e}")


main()
