# Linear mixed models by lme4, lmerTest and pbkrtest, with the data they were fitted to, as JSON on
# the standard output: crates/stats/tests/r.rs fits the same data and compares.
#
#     Rscript mixed_models.R [RANDOM [SEED]]
#
# RANDOM data sets are drawn beside those of R's packages, each from SEED and its number: ties, missing cells, variances
# of zero, one participant, values that are all equal.

suppressPackageStartupMessages({
  library(lme4)
  library(lmerTest)
  library(pbkrtest)
  library(jsonlite)
})
options(warn = -1)
given <- commandArgs(TRUE)
count <- if (length(given) >= 1) as.integer(given[1]) else 60L
seed <- if (length(given) >= 2) as.integer(given[2]) else 20240501L

# lme4 as tight as it goes, from several starts, because its default stops early
tight <- function(formula, data, REML) {
  fit <- function(start) {
    control <- lmerControl(
      optimizer = "bobyqa", optCtrl = list(rhobeg = 0.1, rhoend = 1e-12, maxfun = 1e5),
      calc.derivs = FALSE, check.nobs.vs.nlev = "ignore", check.nobs.vs.nRE = "ignore", check.nlev.gtr.1 = "ignore"
    )
    # the data inside the call: lmerTest evaluates it again elsewhere
    suppressMessages(do.call(lme4::lmer, list(formula, data, REML = REML, control = control, start = start)))
  }
  first <- fit(NULL)
  theta <- getME(first, "theta")
  lower <- getME(first, "lower")
  # Where an intercept's SD is small beside a slope's, bobyqa may rest at zero (data sets 428 and 657 of the default seed,
  # 4e-3 above the minimum that a start with a correlation finds).
  starts <- list(theta, ifelse(lower == 0, 0.2, 0), ifelse(lower == 0, 3, 0))
  if (any(lower < 0)) starts <- c(starts, list(rep(0.3, length(theta)), ifelse(lower == 0, 0.3, -0.3)))
  fits <- c(list(first), lapply(starts, fit))
  fits[[which.min(sapply(fits, function(f) if (REML) REMLcrit(f) else deviance(f, REML = FALSE)))]]
}

# Whether the covariances of the random terms and the identity are linearly independent beside X
identified <- function(fit) {
  X <- getME(fit, "X")
  M <- diag(nrow(X)) - X %*% solve(crossprod(X), t(X))
  G <- lapply(get_SigmaG(fit)$G, function(g) as.vector(M %*% as.matrix(g) %*% M))
  size <- sqrt(sapply(G, function(g) sum(g^2)))
  plain <- sqrt(sapply(get_SigmaG(fit)$G, function(g) sum(g^2)))
  if (any(size < 1e-5 * plain)) return(FALSE)
  min(eigen(crossprod(mapply(function(g, s) g / s, G, size)), only.values = TRUE)$values) > 1e-8
}

# A1 and A2 of Kenward and Roger's section 3, from pbkrtest's own matrices
moments <- function(fit, L) {
  adjusted <- vcovAdj(fit)
  phi <- as.matrix(vcov(fit))
  P <- attr(adjusted, "P")
  W <- as.matrix(attr(adjusted, "W"))
  theta <- t(L) %*% solve(L %*% phi %*% t(L), L)
  parts <- lapply(P, function(p) theta %*% phi %*% as.matrix(p) %*% phi)
  traces <- sapply(parts, function(u) sum(diag(u)))
  crossed <- outer(seq_along(P), seq_along(P), Vectorize(function(i, j) sum(parts[[i]] * t(parts[[j]]))))
  list(a1 = sum(W * outer(traces, traces)), a2 = sum(W * crossed))
}

contrast <- function(fit, tested, w) {
  kr <- contest(tested, w, joint = FALSE, ddf = "Kenward-Roger")
  sat <- contest(tested, w, joint = FALSE)
  list(
    weights = w, estimate = kr[["Estimate"]], kr_se = kr[["Std. Error"]], kr_df = kr[["df"]],
    se = sat[["Std. Error"]], df = sat[["df"]], kr = moments(fit, matrix(w, 1))
  )
}

# One case: the data as our model takes them, and what R finds; a random term has lme4's name
case <- function(name, formula, data, random, group, REML = TRUE, joint = NULL) {
  y <- data[[all.vars(formula)[1]]]
  X <- unname(model.matrix(lme4::nobars(formula), data))
  p <- ncol(X)
  given <- list(
    name = name, reml = REML, response = as.numeric(y), fixed = lapply(seq_len(p), function(j) X[, j]),
    group = as.integer(factor(data[[group]])), random = random
  )
  # lme4 fits neither: our refusal is looked at alone
  given$found <- list(constant = length(unique(y)) == 1, alone = length(unique(data[[group]])) == 1)
  if (given$found$constant || given$found$alone) return(given)
  fit <- tight(formula, data, REML)
  tested <- NULL
  ok <- identified(fit)
  found <- list(
    constant = FALSE, alone = FALSE, identified = ok,
    criterion = if (REML) REMLcrit(fit) else deviance(fit, REML = FALSE),
    coefficients = unname(fixef(fit)),
    se = unname(sqrt(diag(as.matrix(vcov(fit))))),
    residual_variance = sigma(fit)^2,
    covariances = unname(lapply(random, function(t) matrix(VarCorr(fit)[[t$name]], length(t$columns)))),
    singular = isSingular(fit, tol = 1e-5)
  )
  if (ok && REML) {
    tested <- as_lmerModLmerTest(fit)
  }
  if (!is.null(tested)) {
    found$contrasts <- lapply(seq_len(p), function(j) contrast(fit, tested, as.numeric(seq_len(p) == j)))
    if (!is.null(joint)) {
      kr <- contest(tested, joint, ddf = "Kenward-Roger")
      sat <- contest(tested, joint)
      # lmerTest shows the unscaled mean square beside pbkrtest's scaled F
      effect <- joint %*% fixef(fit)
      wald <- sum(effect * solve(joint %*% as.matrix(vcovAdj(fit)) %*% t(joint), effect)) / nrow(joint)
      found$joint <- list(
        weights = joint, kr_f = kr[["F value"]], kr_f_unscaled = wald, kr_df = kr[["DenDF"]], kr = moments(fit, joint),
        f = sat[["F value"]], df = sat[["DenDF"]]
      )
    }
  }
  given$found <- found
  given
}

term <- function(name, level, ...) list(name = name, level = as.integer(factor(level)), columns = list(...))

package_cases <- function() {
  data(sleepstudy, package = "lme4", envir = environment())
  data(Dyestuff, Dyestuff2, package = "lme4", envir = environment())
  one <- rep(1, nrow(sleepstudy))
  days <- term("Subject", one, one, sleepstudy$Days)
  subject <- term("Subject", one, one)
  orthodont <- as.data.frame(nlme::Orthodont)
  orthodont$Subject <- factor(as.character(orthodont$Subject))
  ones <- rep(1, nrow(orthodont))
  machines <- as.data.frame(nlme::Machines)
  machines$Worker <- factor(as.character(machines$Worker))
  each <- rep(1, nrow(machines))
  thirty <- rep(1, 30)
  modes <- rbind(c(0, 1, 0), c(0, 0, 1))
  machine_terms <- list(term("Worker", each, each), term("Worker:Machine", machines$Machine, each))
  list(
    case("sleepstudy (Days | Subject)", Reaction ~ Days + (Days | Subject), sleepstudy, list(days), "Subject"),
    case("sleepstudy (Days | Subject) ML", Reaction ~ Days + (Days | Subject), sleepstudy, list(days), "Subject", FALSE),
    case("sleepstudy (1 | Subject)", Reaction ~ Days + (1 | Subject), sleepstudy, list(subject), "Subject"),
    case(
      "Orthodont (1 | Subject)", distance ~ age * Sex + (1 | Subject), orthodont,
      list(term("Subject", ones, ones)), "Subject"
    ),
    case(
      "Orthodont (age | Subject)", distance ~ age * Sex + (age | Subject), orthodont,
      list(term("Subject", ones, ones, orthodont$age)), "Subject"
    ),
    case(
      "Machines", score ~ Machine + (1 | Worker) + (1 | Worker:Machine), machines, machine_terms, "Worker",
      joint = modes
    ),
    case("Dyestuff", Yield ~ 1 + (1 | Batch), Dyestuff, list(term("Batch", thirty, thirty)), "Batch"),
    case("Dyestuff2", Yield ~ 1 + (1 | Batch), Dyestuff2, list(term("Batch", thirty, thirty)), "Batch")
  )
}

# A study drawn at random
draw <- function(number) {
  set.seed(seed + number)
  repeat {
    n <- sample(1:8, 1)
    modes <- sample(2:3, 1)
    sessions <- sample(1:2, 1)
    repeats <- sample(1:4, 1)
    d <- expand.grid(r = seq_len(repeats), m = factor(seq_len(modes)), s = factor(seq_len(sessions)), p = factor(seq_len(n)))
    sd <- sample(c(0, 0, 0.3, 1, 5), 4, TRUE)
    pm <- interaction(d$p, d$m)
    ps <- interaction(d$p, d$s)
    psm <- interaction(d$p, d$s, d$m)
    effect <- function(f, sd) (sd * rnorm(nlevels(f)))[as.integer(f)]
    d$y <- 10 + as.integer(d$m) + effect(d$p, sd[1]) + effect(pm, sd[2]) + effect(ps, sd[3]) + effect(psm, sd[4]) + rnorm(nrow(d))
    if (runif(1) < 0.3) d$y <- round(d$y) # ties
    if (runif(1) < 0.4) d <- d[runif(nrow(d)) > 0.2, ] # trials missing
    if (runif(1) < 0.3) d <- d[!(d$p == 1 & d$m == 1), ] # a cell missing
    d <- droplevels(d)
    if (runif(1) < 0.02) d$y <- 10 # all equal
    if (nlevels(d$m) < 2 || nrow(d) < 8) next
    one <- rep(1, nrow(d))
    terms <- list(term("p", one, one), term("p:m", d$m, one))
    formula <- "y ~ m + (1 | p) + (1 | p:m)"
    if (nlevels(d$s) > 1) {
      formula <- paste(sub("m \\+", "m + s +", formula), "+ (1 | p:s)")
      terms <- c(terms, list(term("p:s", d$s, one)))
      if (runif(1) < 0.5) {
        formula <- paste(formula, "+ (1 | p:s:m)")
        terms <- c(terms, list(term("p:s:m", interaction(d$s, d$m, drop = TRUE), one)))
      }
    } else if (runif(1) < 0.3) {
      formula <- "y ~ m + (1 + r | p)"
      terms <- list(term("p", one, one, d$r))
      if (length(unique(d$r)) < 2) next
    }
    if (runif(1) < 0.2 && length(terms) > 1) {
      formula <- "y ~ m + (1 | p)"
      terms <- terms[1]
    }
    X <- model.matrix(as.formula(lme4::nobars(as.formula(formula))), d)
    if (qr(X)$rank < ncol(X)) next
    joint <- if (nlevels(d$m) == 3) cbind(rbind(c(0, 1, 0), c(0, 0, 1)), matrix(0, 2, ncol(X) - 3)) else NULL
    found <- tryCatch(
      case(paste0("random ", number, ": ", formula), as.formula(formula), d, terms, "p", joint = joint),
      error = function(e) NULL
    )
    if (!is.null(found)) return(found)
  }
}

# Two processes: each case has a seed of its own
drawn <- parallel::mclapply(seq_len(count), draw, mc.cores = 2, mc.preschedule = FALSE)
failed <- Filter(function(case) !is.list(case), drawn)
if (length(failed) > 0) stop("a case has no result: ", failed[[1]])
cases <- c(package_cases(), drawn)
cat(toJSON(cases, digits = I(17), auto_unbox = FALSE, matrix = "rowmajor"))
