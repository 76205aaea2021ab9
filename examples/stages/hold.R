# A stage of a study's own in R, which needs no package: how long the lever is held near its farthest point, and a figure.
#
# It lies as analysis/<study>/hold.R beside raw/. In study.toml:
#
#     [[stage]]
#     id = "hold"
#     command = ["Rscript", "hold.R"]
#     files = ["hold.R"]
#     inputs = ["samples"]
#     format = "csv"
#     gives = [{ id = "hold", unit = "s", label = "time near the farthest point", better = "lower" }]
#     figures = [{ file = "hold.png", caption = "Time near the farthest point by mode." }]
#
# Then `zwidth allow STUDY`, and `zwidth run STUDY`.

samples <- read.csv("in/samples.csv")
keys <- c("participant", "session", "trial", "mode")
trials <- split(samples, samples[c("participant", "session", "trial")], drop = TRUE)

hold <- function(trial) {
  step_s <- c(diff(trial$t_s), 0)
  # Within a tenth of the way from the farthest point.
  near <- trial$theta_rad >= max(trial$theta_rad) - 0.1 * diff(range(trial$theta_rad))
  cbind(trial[1, keys], hold = sum(step_s[near]))
}
table <- do.call(rbind, lapply(trials, hold))
# R writes NA for a missing value, which is read as one.
write.csv(table[c("participant", "session", "trial", "hold")], "out/table.csv", row.names = FALSE, quote = FALSE)

# png() gives the same bytes twice, pdf() does not.
png("out/figures/hold.png", width = 800, height = 600, res = 150, type = "cairo")
boxplot(hold ~ mode, data = table, xlab = "", ylab = "time near the farthest point in s")
invisible(dev.off())
