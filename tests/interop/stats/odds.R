# The cumulative-logit model of one question by R's package ordinal: one JSON text on standard output.
#
#   Rscript odds.R ANSWERS.csv
#
# The file has columns `question`, `answer`, `participant` and `mode`; the first mode of a question is the reference. Each
# question's model has an effect of the participant, integrated out by adaptive Gauss–Hermite quadrature with 50 nodes
# (nAGQ is positive: -50 would keep them around zero), and is searched until nothing moves. Where R's own
# search for a participant's mode fails there is a message instead.

suppressPackageStartupMessages({
  library(ordinal)
  library(jsonlite)
})

tight <- clmm.control(maxIter = 200, gradTol = 1e-7, grtol = 1e-9, xtol = 1e-14)

log_likelihood <- function(formula, data) {
  as.numeric(logLik(clmm(formula, data = data, nAGQ = 50, control = tight)))
}

of_question <- function(data) {
  data$y <- factor(data$answer, ordered = TRUE)
  data$who <- factor(data$participant)
  others <- unique(data$mode)[-1]
  columns <- paste0("against_", others)
  data[columns] <- lapply(others, function(mode) as.numeric(data$mode == mode))
  formula <- function(columns) as.formula(paste("y ~", paste(c(columns, "(1 | who)"), collapse = " + ")))
  tryCatch({
    fit <- clmm(formula(columns), data = data, nAGQ = 50, control = tight)
    top <- as.numeric(logLik(fit))
    without <- vapply(columns, function(column) log_likelihood(formula(setdiff(columns, column)), data), 0)
    list(log_likelihood = top, sd = abs(fit$ST$who[1, 1]), none = log_likelihood(formula(character()), data),
         modes = others, odds_ratio = exp(-unname(coef(fit)[columns])), without = unname(without))
  }, error = function(e) list(refused = conditionMessage(e)))
}

answers <- read.csv(commandArgs(trailingOnly = TRUE)[1])
by_question <- split(answers, factor(answers$question, unique(answers$question)))
cat(toJSON(lapply(by_question, of_question), auto_unbox = TRUE, digits = NA))
