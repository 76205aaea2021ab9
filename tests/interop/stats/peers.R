# What lmerTest, pbkrtest and emmeans print of differences between modes, as JSON, for tests/interop/peers.py.
#
#     Rscript peers.R FILE.csv      columns participant, mode, value
#
# Per call and pair of modes: estimate, standard error, degrees of freedom, t, p; of emmeans estimate, standard error,
# degrees of freedom, ends of the interval, effect size, p.

suppressPackageStartupMessages({
  library(lmerTest)
  library(pbkrtest)
  library(emmeans)
  library(jsonlite)
})
data <- read.csv(commandArgs(TRUE)[1], stringsAsFactors = TRUE)
# lme4's own stopping rule leaves four digits
tight <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhobeg = 0.1, rhoend = 1e-12, maxfun = 1e5), calc.derivs = FALSE)
with_modes <- value ~ mode + (1 | participant) + (1 | participant:mode)
modes <- levels(data$mode)

# The coefficients of every mode against every other, each in turn the reference
coefficients <- function(formula, ...) {
  all <- list()
  for (against in modes) {
    own <- transform(data, mode = relevel(mode, ref = against))
    fit <- suppressMessages(do.call(lmer, list(formula, own, control = tight)))
    table <- coef(summary(fit, ...))
    for (first in setdiff(modes, against)) {
      all[[paste(first, against)]] <- unname(table[paste0("mode", first), ])
    }
  }
  all
}

pairs_of_modes <- function() {
  fit <- suppressMessages(lmer(with_modes, data, control = tight))
  means <- emmeans(fit, ~mode)
  printed <- as.data.frame(summary(pairs(means), infer = c(TRUE, TRUE)))
  sizes <- as.data.frame(eff_size(means, sigma = sigma(fit), edf = df.residual(fit)))$effect.size
  all <- list()
  for (i in seq_len(nrow(printed))) {
    pair <- strsplit(as.character(printed$contrast[i]), " - ")[[1]]
    row <- printed[i, ]
    all[[paste(pair, collapse = " ")]] <- c(row$estimate, row$SE, row$df, row$lower.CL, row$upper.CL, sizes[i], row$p.value)
    all[[paste(rev(pair), collapse = " ")]] <- c(-row$estimate, row$SE, row$df, -row$upper.CL, -row$lower.CL, -sizes[i], row$p.value)
  }
  all
}

cat(toJSON(list(
  intercept = coefficients(value ~ mode + (1 | participant)),
  modes = coefficients(with_modes),
  kenward_roger = coefficients(with_modes, ddf = "Kenward-Roger"),
  emmeans = pairs_of_modes()
), digits = NA))
