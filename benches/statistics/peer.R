# One round of R's side: fits each CSV file named, says what it found, and how long a fit takes (s, the median).
#
#   Rscript peer.R FILE...
#
# Columns: participant, session, mode, value, answer. By the file's name: mixed_... is fitted by lme4 and tested by pbkrtest,
# ordinal_... by ordinal's clmm. All with the settings that these packages come with. Not on the clock: packages
# loaded, data read, columns made factors, a first fit.

suppressPackageStartupMessages({
  library(lme4)
  library(pbkrtest)
  library(ordinal)
})
# fits go on for so many seconds: of a slow one, one is timed a round
SECONDS <- 0.5

mixed <- function(data) {
  sessions <- nlevels(data$session)
  formula <- if (sessions > 1) {
    value ~ 0 + cell + (1 | participant) + (1 | participant:mode) + (1 | participant:session) +
      (1 | participant:session:mode)
  } else {
    value ~ 0 + cell + (1 | participant) + (1 | participant:mode)
  }
  modes <- nlevels(data$mode)
  # cells are modes within sessions: a contrast is the mean over sessions
  weights <- lapply(2:modes, function(mode) {
    rep((seq_len(modes) == mode) - (seq_len(modes) == 1), times = sessions) / sessions
  })
  function() {
    fit <- lmer(formula, data)
    plain <- vcov(fit)
    adjusted <- vcovAdj(fit)
    one <- function(of) vapply(weights, of, 0)
    list(criterion = REMLcrit(fit), estimate = one(function(w) sum(w * fixef(fit))),
         se = one(function(w) sqrt(as.numeric(w %*% adjusted %*% w))),
         df = one(function(w) Lb_ddf(w, plain, adjusted)))
  }
}

answers <- function(data) {
  function() {
    fit <- clmm(answer ~ mode + (1 | participant) + (1 | participant:mode), data = data)
    named <- paste0("mode", levels(data$mode)[-1])
    list(criterion = as.numeric(logLik(fit)), estimate = unname(coef(fit)[named]),
         se = unname(sqrt(diag(vcov(fit))[named])))
  }
}

say <- function(case, what, values) cat(sprintf("%s\t%s\t%.17g\n", case, what, values), sep = "")

for (package in c("lme4", "pbkrtest", "ordinal")) {
  cat(sprintf("version\t%s %s\t0\n", package, packageVersion(package)))
}
cat(sprintf("version\tR %s\t0\n", getRversion()))
for (file in commandArgs(TRUE)) {
  data <- read.csv(file)
  data$session <- factor(data$session)
  data$participant <- factor(data$participant)
  data$mode <- factor(data$mode)
  data$answer <- factor(data$answer, levels = 1:5, ordered = TRUE)
  data$cell <- interaction(data$session, data$mode, lex.order = TRUE)
  case <- sub("\\.csv$", "", basename(file))
  fit <- if (startsWith(case, "mixed")) mixed(data) else answers(data)
  found <- fit()
  for (what in names(found)) say(case, what, found[[what]])
  seconds <- c()
  while (sum(seconds) < SECONDS) {
    began <- Sys.time()
    fit()
    seconds <- c(seconds, as.numeric(Sys.time() - began, units = "secs"))
  }
  say(case, "seconds", median(seconds))
}
