//! Gauss–Hermite quadrature: ∫ f(x) dx over the real line from few values of f.

/// Nodes and weights of the rule with n nodes, in ascending order.
///
/// ∫ f(x) dx ≈ Σ wᵢ f(xᵢ) is exact where f(x) = e^(−x²) p(x) with a polynomial p of degree at most
/// 2n − 1. The weights hold the factor exp(xᵢ²), so that large rules neither over- nor underflow.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rule {
    /// xᵢ, the zeros of the Hermite polynomial of degree n; symmetric about 0.
    pub(super) nodes: Vec<f64>,
    /// wᵢ = exp(xᵢ²) times the weight of the classical rule.
    pub(super) weights: Vec<f64>,
}

/// The Gauss–Hermite rule with `n` nodes.
///
/// The nodes are the eigenvalues of the Jacobi matrix with zeros on its diagonal and √(k/2) beside
/// it (Golub & Welsch 1969, Math. Comp. 23:221), found by bisection on the count of eigenvalues
/// (Wilkinson 1965, *The Algebraic Eigenvalue Problem*, §5.38). The weights are Christoffel's
/// numbers 1 / Σ ψₖ(xᵢ)² over k < n with the orthonormal Hermite functions ψₖ: a sum of positive
/// terms. Meant for n up to some hundreds; beyond 1400 the outermost functions underflow.
pub(super) fn rule(n: usize) -> Rule {
    let mut nodes = vec![0.0; n];
    for i in 0..n / 2 {
        let root = positive_root(n, n - 1 - i);
        nodes[n - 1 - i] = root;
        nodes[i] = -root;
    }
    let weights = nodes.iter().map(|&x| 1.0 / squared_functions(n, x)).collect();
    Rule { nodes, weights }
}

/// The eigenvalue above which n − 1 − `index` others lie, where it is positive.
fn positive_root(n: usize, index: usize) -> f64 {
    // All zeros lie within √(2n + 1) (Szegő 1939, §6.31).
    let (mut low, mut high) = (0.0, (2.0 * n as f64 + 1.0).sqrt());
    loop {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            return middle;
        }
        if eigenvalues_below(n, middle) > index {
            high = middle;
        } else {
            low = middle;
        }
    }
}

/// How many eigenvalues of the Jacobi matrix lie below `x`: the negative pivots of J − x I.
fn eigenvalues_below(n: usize, x: f64) -> usize {
    let mut pivot = -x;
    let mut count = usize::from(pivot < 0.0);
    for k in 1..n {
        // A pivot of 0 stands for one just above it.
        let divisor = if pivot.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { pivot };
        pivot = -x - k as f64 / 2.0 / divisor;
        count += usize::from(pivot < 0.0);
    }
    count
}

/// Σ ψₖ(x)² over k < n: ψ₀ = π^(−1/4) e^(−x²/2),
/// ψₖ₊₁ = √(2/(k + 1)) x ψₖ − √(k/(k + 1)) ψₖ₋₁.
fn squared_functions(n: usize, x: f64) -> f64 {
    let first = libm::exp(-x * x / 2.0) / libm::pow(core::f64::consts::PI, 0.25);
    let (mut before, mut here, mut sum) = (0.0, first, 0.0);
    for k in 0..n {
        sum += here * here;
        let next = k as f64 + 1.0;
        let after = (2.0 / next).sqrt() * x * here - (k as f64 / next).sqrt() * before;
        (before, here) = (here, after);
    }
    sum
}

mod tests {
    use super::*;

    fn integral(rule: &Rule, f: impl Fn(f64) -> f64) -> f64 {
        rule.nodes.iter().zip(&rule.weights).map(|(&x, w)| w * f(x)).sum()
    }

    #[test]
    fn rules_of_one_two_and_three_nodes_have_their_closed_forms() {
        let root_pi = core::f64::consts::PI.sqrt();
        let e = libm::exp(1.0);
        let check = |n, nodes: &[f64], weights: &[f64]| {
            let rule = rule(n);
            for i in 0..n {
                assert!((rule.nodes[i] - nodes[i]).abs() < 1e-15, "{rule:?}");
                assert!((rule.weights[i] - weights[i]).abs() < 2e-15, "{rule:?}");
            }
        };
        check(1, &[0.0], &[root_pi]);
        let half = 0.5_f64.sqrt();
        check(2, &[-half, half], &[root_pi / 2.0 * e.sqrt(); 2]);
        let outer = root_pi / 6.0 * libm::exp(1.5);
        check(3, &[-1.5_f64.sqrt(), 0.0, 1.5_f64.sqrt()], &[outer, root_pi * 2.0 / 3.0, outer]);
    }

    /// ∫ x²ᵏ e^(−x²) dx = Γ(k + ½), exact up to degree 2n − 1, and not beyond.
    #[test]
    fn even_moments_are_gamma_functions_up_to_the_degree_of_the_rule() {
        for n in [1, 2, 5, 10, 21, 60, 100, 200] {
            let rule = rule(n);
            let moment = |k: usize| {
                let log = |x: f64| 2.0 * k as f64 * libm::log(x.abs()) - x * x;
                let found =
                    integral(&rule, |x| if k == 0 { libm::exp(-x * x) } else { libm::exp(log(x)) });
                found / libm::tgamma(k as f64 + 0.5)
            };
            for k in 0..n.min(100) {
                assert!((moment(k) - 1.0).abs() < 2e-12, "n {n}, x^{}: {}", 2 * k, moment(k));
            }
            if n <= 21 {
                assert!((moment(n) - 1.0).abs() > 1e-9, "n {n} is exact beyond its degree");
            }
        }
    }

    /// ∫ cos(x) e^(−x²) dx = √π e^(−1/4).
    #[test]
    fn an_analytic_function_is_integrated_to_rounding() {
        let exact = core::f64::consts::PI.sqrt() * libm::exp(-0.25);
        let found = integral(&rule(20), |x| libm::cos(x) * libm::exp(-x * x));
        assert!((found - exact).abs() < 1e-14, "{found}");
    }

    #[test]
    fn no_nodes_are_an_empty_rule() {
        assert_eq!(rule(0), Rule { nodes: vec![], weights: vec![] });
    }
}
