# The studies that tests make by formula, and what R makes of them: a list of studies as JSON on the standard output, each with
# its data and its values. crates/stats/tests/r.rs asks the same of our functions.
#
#     Rscript reference.R
#
# Values: [estimate, standard error, t, df, p, low, high] at 95 % where nothing else is said.

suppressPackageStartupMessages({
  library(lme4)
  library(pbkrtest)
  library(jsonlite)
})
options(warn = -1) # pt() with a noncentrality says where it has fewer digits than it could

# A number between -1/2 and 1/2: (h^3 mod 9941)/9941 - 1/2 with whole h, exact in double precision
u <- function(a, b = 0, c = 0, d = 0) ((1 + 131 * a + 173 * b + 197 * c + 211 * d)^3 %% 9941) / 9941 - 0.5

of_t <- function(test, estimate) {
  c(estimate, unname(c(test$stderr, test$statistic, test$parameter, test$p.value)), as.numeric(test$conf.int))
}
one_sample <- function(values) of_t(t.test(values), mean(values))
welch <- function(a, b) of_t(t.test(a, b), mean(a) - mean(b))
kenward_roger <- function(fit, weights) {
  covariance <- as.matrix(vcovAdj(fit))
  error <- sqrt(as.numeric(weights %*% covariance %*% weights))
  c(sum(weights * fixef(fit)), error, get_Lb_ddf(fit, weights))
}
# Ends of d are those of the noncentrality of t, whose 97.5 and 2.5 % points it is
noncentralities <- function(t, df) {
  sapply(c(0.975, 0.025), function(share) {
    uniroot(function(ncp) pt(t, df, ncp) - share, t + c(-8, 8), tol = 1e-12)$root
  })
}
# d, g and the interval of d
sized <- function(d, df, ends) c(d, d * exp(lgamma(df / 2) - lgamma((df - 1) / 2)) / sqrt(df / 2), ends)
precise <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhobeg = 0.1, rhoend = 1e-12, maxfun = 1e5), calc.derivs = FALSE)
mixed <- function(formula, data) suppressMessages(do.call(lmer, list(formula, data, control = precise)))
by_person <- function(values, ...) tapply(values, list(...), mean)

groups <- function() {
  d <- expand.grid(r = 1:4, m = 0:2, p = 1:12)
  d$expert <- as.numeric(d$p > 7)
  d$y <- with(d, round(2 + 0.25 * m + (0.15 + 0.3 * expert) * (m == 2) + 0.8 * u(p) + 0.6 * (1 + 2 * expert) * u(p, m + 1) +
    0.4 * u(p, m + 1, r), 3))
  means <- by_person(d$y, d$p, d$m)
  expert <- 1:12 > 7
  band <- factor(1:12 %% 3)
  age <- 19 + (7 * 1:12) %% 23
  c <- means[, 3] - means[, 1]
  each <- list(c[!expert], c[expert])
  variances <- sapply(each, function(own) var(own) / length(own) / 4)
  equal_df <- sum(variances)^2 / sum(variances^2 / (lengths(each) - 1))
  equal <- sum(sapply(each, mean)) / 2
  equal_t <- equal / sqrt(sum(variances))
  permuted <- function(values) {
    t2 <- function(first) welch(values[first], values[-first])[3]^2
    arrangements <- combn(12, 5, t2)
    c(length(arrangements), sum(arrangements >= t2(which(expert)) * (1 - 1e-12)))
  }
  f <- oneway.test(c ~ band)
  slope <- summary(lm(c ~ I(age - mean(age))))
  d$person <- factor(d$p)
  d$mode <- factor(d$m)
  full <- y ~ expert * mode + (1 | person) + (1 | person:mode)
  fit <- mixed(full, d)
  sds <- as.data.frame(VarCorr(fit))
  # Coefficients: 1, expert, mode 1, mode 2, expert:mode 1, expert:mode 2
  joint <- KRmodcomp(fit, rbind(c(0, 0, 0, 0, 1, 0), c(0, 0, 0, 0, 0, 1)))$test["Ftest", ]
  within <- function(a, b) {
    n <- length(a)
    ends <- noncentralities(unname(t.test(a, b, paired = TRUE)$statistic), n - 1)
    spread <- sd(a - b)
    both <- sqrt((var(a) + var(b)) / 2)
    df <- (n - 1) * (var(a) + var(b))^2 / (var(a)^2 + var(b)^2 + 2 * cov(a, b)^2)
    list(
      d_z = sized(mean(a - b) / spread, n - 1, ends / sqrt(n)),
      d_av = sized(mean(a - b) / both, df, ends * spread / (both * sqrt(n)))
    )
  }
  between <- function(a, b) {
    found <- welch(a, b)
    both <- sqrt((var(a) + var(b)) / 2)
    df <- (var(a) + var(b))^2 / (var(a)^2 / (length(a) - 1) + var(b)^2 / (length(b) - 1))
    sized(found[1] / both, df, noncentralities(found[3], found[4]) * found[2] / both)
  }
  list(
    name = "groups", participant = d$p, mode = d$m, expert = d$expert, value = d$y, age = age,
    values = c(
      list(
        expert_minus_novice_of_c = welch(c[expert], c[!expert]),
        expert_minus_novice_in_hybrid = welch(means[expert, 3], means[!expert, 3]),
        expert_minus_novice_of_mean_over_modes = welch(rowMeans(means)[expert], rowMeans(means)[!expert]),
        c_groups_with_equal_weight = c(equal, sqrt(sum(variances)), equal_t, equal_df, 2 * pt(-abs(equal_t), equal_df)),
        c_in_novice = one_sample(c[!expert]),
        c_in_expert = one_sample(c[expert]),
        c_one_t_over_all_people = one_sample(c),
        permutations_of_c = permuted(c),
        permutations_in_hybrid = permuted(means[, 3]),
        welch_f_of_c_over_band = unname(c(f$statistic, f$parameter, f$p.value)),
        c_per_year_of_age = c(slope$coefficients[2, 1:2], slope$df[2], slope$coefficients[2, 4], slope$coefficients[1, 1:2]),
        kr = c(REMLcrit(fit), sds$sdcor[sds$grp == "person:mode"], sds$sdcor[sds$grp == "person"], sigma(fit)),
        kr_group_difference_of_c = kenward_roger(fit, c(0, 0, 0, 0, 0, 1)),
        kr_c_equal_weight = kenward_roger(fit, c(0, 0, 0, 1, 0, 0.5)),
        kr_group_over_modes = kenward_roger(fit, c(0, 1, 0, 0, 1 / 3, 1 / 3)),
        kr_f_group_by_mode = c(joint$stat, joint$ndf, joint$ddf, joint$p.value)
      ),
      within(means[, 3], means[, 1]),
      list(between_c = between(c[expert], c[!expert]))
    )
  )
}

factorial <- function() {
  d <- expand.grid(r = 1:3, b = 0:1, a = 0:1, e = 0:1, p = 1:8)
  key <- with(d, u(p, 40 + 4 * e + 2 * a + b, r))
  d <- d[order(d$p, d$e, d$r, key), ]
  d$t <- 12 * d$e + ave(key, d$p, d$e, FUN = seq_along)
  d$y <- with(d, round(1 + 0.4 * a + 0.2 * b + 0.25 * a * b + 0.3 * e - 0.2 * a * b * e + 0.7 * u(p) + 0.4 * a * u(p, 1 + a, 9) +
    0.4 * b * u(p, 3 + b, 9) + 0.3 * u(p, 5 + 2 * a + b, e + 1) - 0.02 * t + 0.3 * u(p, 9 + 2 * a + b + 4 * e, r), 3))
  # People × conditions (none, brake, motor, both) of an environment
  means <- function(e) with(d[d$e == e, ], by_person(y, p, 2 * a + b))
  weights <- cbind(motor = c(-1, -1, 1, 1) / 2, brake = c(-1, 1, -1, 1) / 2, motor_brake = c(1, -1, -1, 1))
  effects <- function(table) table %*% weights
  spring <- effects(means(0))
  wall <- effects(means(1))
  # Everybody's own line over trials, besides the means of the conditions
  lines <- function(e) {
    t(sapply(1:8, function(p) coef(lm(y ~ 0 + factor(2 * a + b) + t, d[d$p == p & d$e == e, ]))))
  }
  along <- lapply(0:1, lines)
  values <- c(
    setNames(lapply(1:3, function(k) one_sample(spring[, k])), paste0("spring_", colnames(weights))),
    setNames(lapply(1:3, function(k) one_sample(wall[, k])), paste0("wall_", colnames(weights)))
  )
  strata <- function(e) {
    own <- aggregate(y ~ p + a + b, d[d$e == e, ], mean)
    own[c("p", "a", "b")] <- lapply(own[c("p", "a", "b")], factor)
    parts <- summary(aov(y ~ a * b + Error(p / (a * b)), own))
    sapply(c("Error: p:a", "Error: p:b", "Error: p:a:b"), function(part) parts[[part]][[1]][["F value"]][1])
  }
  list(
    name = "factorial", people = 8, spring = means(0), wall = means(1),
    values = c(values, list(
      wall_minus_spring_motor = one_sample(wall[, 1] - spring[, 1]),
      wall_minus_spring_motor_brake = one_sample(wall[, 3] - spring[, 3]),
      holm_of_the_six = p.adjust(sapply(values, function(found) found[5]), "holm"),
      f_of_the_six = unname(c(strata(0), strata(1))),
      spring_motor_brake_by_trial = one_sample(along[[1]][, 1:4] %*% weights[, 3]),
      wall_motor_by_trial = one_sample(along[[2]][, 1:4] %*% weights[, 1]),
      spring_slope_per_trial = one_sample(along[[1]][, 5])
    ))
  )
}

dose <- function() {
  d <- expand.grid(r = 1:3, l = 1:4, p = 1:8)
  levels <- c(100, 150, 250, 400)
  d$x <- levels[d$l]
  d$y <- with(d, round(0.5 + 0.004 * x - 0.000003 * x^2 + 0.6 * u(p) + 0.003 * u(p, 7) * x + 0.3 * u(p, l) + 0.3 * u(p, l, r), 3))
  means <- by_person(d$y, d$p, d$l)
  of_each <- function(formula) apply(means, 1, function(y) coef(lm(formula, data.frame(y = y, x = levels)))[[2]])
  polynomials <- contr.poly(4, scores = levels)
  t2 <- function(table) {
    n <- nrow(table)
    k <- ncol(table)
    t2 <- n * as.numeric(colMeans(table) %*% solve(cov(table), colMeans(table)))
    f <- t2 * (n - k) / ((n - 1) * k)
    c(f, k, n - k, pf(f, k, n - k, lower.tail = FALSE))
  }
  test <- anova(lm(means ~ 1), X = ~1, test = "Spherical")
  # The table of anova.mlm has the p value alone: Box's epsilon of orthonormal contrasts
  spread <- cov(means %*% polynomials)
  epsilon <- sum(diag(spread))^2 / (3 * sum(spread^2))
  parabola <- apply(means, 1, function(y) predict(lm(y ~ x + I(x^2), data.frame(y = y, x = levels)), data.frame(x = 300)))
  d$hundred <- d$x / 100
  d$person <- factor(d$p)
  d$level <- factor(d$l)
  own <- mixed(y ~ hundred + (1 + hundred | person) + (1 | person:level), d)
  alone <- mixed(y ~ hundred + (1 | person), d)
  list(
    name = "dose", participant = d$p, level = d$l, dose = d$hundred, value = d$y, means = means, polynomials = t(polynomials),
    values = list(
      contrasts = as.numeric(polynomials),
      slope_per_n_per_m = one_sample(of_each(y ~ x)),
      quadratic_coefficient = one_sample(apply(means, 1, function(y) {
        coef(lm(y ~ x + I(x^2), data.frame(y = y, x = levels)))[[3]]
      })),
      per_doubling = one_sample(of_each(y ~ log2(x))),
      quadratic_curve_at_300 = one_sample(parabola),
      greenhouse_geisser = c(test[["F"]][1], epsilon, test[["G-G Pr"]][1], test[["Pr(>F)"]][1]),
      lack_of_fit_of_the_line = t2(means %*% polynomials[, 2:3]),
      hotelling_all = t2(means %*% polynomials),
      kr_random_slope_and_level = c(kenward_roger(own, c(0, 1)), REMLcrit(own)),
      random_intercept_alone = kenward_roger(alone, c(0, 1))[2:3]
    )
  )
}

scales <- function() {
  halves_up <- function(x) floor(x + 0.5)
  within <- function(x, low, high) pmin(pmax(x, low), high)
  grid <- expand.grid(p = 1:10, m = 0:1)
  g <- with(grid, 1.8 * u(p, 1) + 0.7 * u(p, 2, m) + 0.4 * m)
  sus <- sapply(1:10, function(i) {
    s <- g + 1.2 * u(grid$p, 20 + i, grid$m + 1)
    if (i %% 2 == 1) within(halves_up(3.3 + s), 1, 5) else within(halves_up(3 - s), 1, 5)
  })
  tlx <- sapply(0:5, function(i) within(5 * halves_up(10 - 3 * g + 10 * u(grid$p, 40 + i, grid$m + 1)), 0, 100))
  weights <- t(sapply(1:10, function(p) rank(u(p, 60 + 0:5)) - 1))
  turned <- sapply(1:10, function(i) if (i %% 2 == 1) sus[, i] else 6 - sus[, i])
  score <- (rowSums(turned) - 10) * 2.5
  raw <- rowMeans(tlx)
  weighted <- rowSums(tlx * weights[grid$p, ]) / 15
  compared <- function(score) {
    hybrid <- score[grid$m == 1]
    active <- score[grid$m == 0]
    test <- t.test(hybrid, active, paired = TRUE)
    c(mean(active), mean(hybrid), mean(hybrid - active), test$stderr, test$p.value)
  }
  # Feldt, Woodruff & Salih (1987): 1 - (1 - alpha) F
  alpha <- function(items) {
    n <- nrow(items)
    k <- ncol(items)
    alpha <- k / (k - 1) * (1 - sum(diag(var(items))) / sum(var(items)))
    c(alpha, 1 - (1 - alpha) * qf(c(0.975, 0.025), n - 1, (n - 1) * (k - 1)))
  }
  # One factor by maximum likelihood: factanal's loadings are of standardised items
  omega <- function(items) {
    fit <- factanal(items, 1, lower = 1e-6, control = list(opt = list(factr = 1e1, pgtol = 1e-12)))
    spread <- apply(items, 2, sd)
    common <- sum(fit$loadings[, 1] * spread)^2
    c(common / (common + sum(fit$uniquenesses * spread^2)), min(fit$uniquenesses))
  }
  of_mode <- function(m, items) turned[grid$m == m, items]
  odd <- c(1, 3, 5, 7, 9)
  list(
    name = "scales", active = of_mode(0, 1:10), hybrid = of_mode(1, 1:10), odd = of_mode(1, odd),
    values = list(
      sus = compared(score),
      tlx_raw = compared(raw),
      tlx_weighted = compared(weighted),
      p01_active = c(score[1], raw[1], weighted[1]),
      alpha_sus_active = alpha(of_mode(0, 1:10)),
      alpha_sus_hybrid = alpha(of_mode(1, 1:10)),
      odd_items_hybrid = c(alpha(of_mode(1, odd))[1], omega(of_mode(1, odd))),
      # Its smallest uniqueness is on the bound: nothing that an omega is made of
      odd_items_active = c(alpha(of_mode(0, odd))[1], omega(of_mode(0, odd))[2])
    )
  )
}

cat(toJSON(list(groups(), factorial(), dose(), scales()), digits = I(17), matrix = "rowmajor"))
