//! Butcher tableaux: explicit Runge–Kutta methods as data.

/// An explicit Runge–Kutta method of `S` stages.
#[derive(Debug, Clone, Copy)]
pub struct Tableau<const S: usize> {
    /// Nodes: stage `i` is at `t + c[i] h`.
    pub c: [f64; S],
    /// Stage weights, strictly lower triangular.
    pub a: [[f64; S]; S],
    /// Weights of the step.
    pub b: [f64; S],
    /// Weights of the error estimate (`b` minus the embedded method's); zero without one.
    pub error: [f64; S],
    /// Order of the step.
    pub order: i32,
}

/// The classical method of order 4 (Kutta 1901), the thesis' choice.
pub const RK4: Tableau<4> = Tableau {
    c: [0.0, 0.5, 0.5, 1.0],
    a: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    b: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    error: [0.0; 4],
    order: 4,
};

/// Dormand–Prince 5(4), seven stages, the last one the next step's first
/// (Dormand & Prince 1980; Hairer, Nørsett & Wanner, *Solving ODEs I*, table II.5.2).
pub const DORMAND_PRINCE: Tableau<7> = Tableau {
    c: [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0],
    a: [
        [0.0; 7],
        [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0, 0.0],
        [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0, 0.0],
        [
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18656.0,
            0.0,
            0.0,
        ],
        [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0],
    ],
    b: [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0],
    error: [
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ],
    order: 5,
};

/// Weights of Dormand–Prince's continuous extension of order 4: row `i` holds stage `i`'s
/// polynomial in `s = (t - t0)/h`, coefficients of `s, s², s³, s⁴`
/// (Hairer, Nørsett & Wanner, II.6; the form of Shampine 1986).
pub const DORMAND_PRINCE_DENSE: [[f64; 4]; 7] = [
    [
        1.0,
        -8048581381.0 / 2820520608.0,
        8663915743.0 / 2820520608.0,
        -12715105075.0 / 11282082432.0,
    ],
    [0.0; 4],
    [
        0.0,
        131558114200.0 / 32700410799.0,
        -68118460800.0 / 10900136933.0,
        87487479700.0 / 32700410799.0,
    ],
    [0.0, -1754552775.0 / 470086768.0, 14199869525.0 / 1410260304.0, -10690763975.0 / 1880347072.0],
    [
        0.0,
        127303824393.0 / 49829197408.0,
        -318862633887.0 / 49829197408.0,
        701980252875.0 / 199316789632.0,
    ],
    [0.0, -282668133.0 / 205662961.0, 2019193451.0 / 616988883.0, -1453857185.0 / 822651844.0],
    [0.0, 40617522.0 / 29380423.0, -110615467.0 / 29380423.0, 69997945.0 / 29380423.0],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Order conditions up to `order` (the eight trees of Hairer, Nørsett & Wanner, table II.2.1).
    fn check<const S: usize>(m: &Tableau<S>) {
        let sum = |f: &dyn Fn(usize) -> f64| (0..S).map(|i| m.b[i] * f(i)).sum::<f64>();
        let inner =
            |i: usize, f: &dyn Fn(usize) -> f64| (0..S).map(|j| m.a[i][j] * f(j)).sum::<f64>();
        let c = |i: usize| m.c[i];
        let conditions: [(f64, f64); 8] = [
            (sum(&|_| 1.0), 1.0),
            (sum(&c), 1.0 / 2.0),
            (sum(&|i| c(i) * c(i)), 1.0 / 3.0),
            (sum(&|i| inner(i, &c)), 1.0 / 6.0),
            (sum(&|i| c(i) * c(i) * c(i)), 1.0 / 4.0),
            (sum(&|i| c(i) * inner(i, &c)), 1.0 / 8.0),
            (sum(&|i| inner(i, &|j| c(j) * c(j))), 1.0 / 12.0),
            (sum(&|i| inner(i, &|j| inner(j, &c))), 1.0 / 24.0),
        ];
        for (k, (value, expect)) in conditions.into_iter().enumerate() {
            assert!((value - expect).abs() < 1e-15, "condition {k}: {value} instead of {expect}");
        }
        for i in 0..S {
            assert!((inner(i, &|_| 1.0) - m.c[i]).abs() < 2e-15, "stage {i}");
        }
    }

    #[test]
    fn both_methods_meet_the_order_conditions() {
        check(&RK4);
        check(&DORMAND_PRINCE);
    }

    #[test]
    fn the_continuous_extension_ends_in_the_step_and_the_error_weights_cancel() {
        for (row, b) in DORMAND_PRINCE_DENSE.iter().zip(DORMAND_PRINCE.b) {
            assert!((row.iter().sum::<f64>() - b).abs() < 1e-14);
        }
        assert!(DORMAND_PRINCE.error.iter().sum::<f64>().abs() < 1e-16);
    }
}
