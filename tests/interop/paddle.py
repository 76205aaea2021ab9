"""The haptic paddle's modes compared, from the recordings themselves: whoever moved it is one participant, P01."""

import numpy as np
import pandas as pd

from checks import check, equal
from ledger import compared

RATE_HZ = 200.0
# `analysis` of studies/ethz/study.toml: the program's defaults, rad/s.
ONSET, OFFSET = np.radians(10.0), np.radians(5.0)
MODES = ["uncontrolled", "fg_compensated", "force_feedback"]
SESSIONS = ["S09", "S10", "S11", "S12"]
# The default: the last mode against each other one.
CONTRASTS = [("force_feedback", "uncontrolled"), ("force_feedback", "fg_compensated")]
NOT_DRAWN = "the order of P01 S09 was not drawn by this program"
# Sums of a few numbers.
DIGITS = 1e-12


def check_compared(zwidth, root, real):
    """Every number of `zwidth compare ethz`."""
    durations = {
        (session, mode): duration(real / f"ethz_haptic_paddle/transparency/session_{int(session[1:])}/{mode}.csv")
        for session in SESSIONS
        for mode in MODES
    }
    means = {mode: np.mean([durations[session, mode] for session in SESSIONS]) for mode in MODES}
    by_mode = compared(zwidth, root, "ethz", "mode")
    of_means(by_mode["means_duration_s"], means)
    of_contrasts(by_mode["contrasts_duration_s"], means)
    of_orders(by_mode["orders_duration_s"])
    of_participants(compared(zwidth, root, "ethz", "participant")["participants_duration_s"], means)
    of_sessions(compared(zwidth, root, "ethz", "session")["sessions_duration_s"], durations)
    of_repeats(compared(zwidth, root, "ethz", "repeat")["learning_duration_s"])
    sentences(root, [*by_mode["means_duration_s"].notes, *by_mode["contrasts_duration_s"].notes])


def duration(file):
    """From the first sample above the onset's threshold to the first one below the offset's after the last such, s."""
    speed = pd.read_csv(file)["velocity_rad_s"].abs().to_numpy()
    fast = np.flatnonzero(speed > ONSET)
    end = fast[-1] + np.flatnonzero(speed[fast[-1] :] < OFFSET)[0]
    return (end - fast[0]) / RATE_HZ


def of_means(table, means):
    equal(f"{table.label}: rows", len(table.frame), len(MODES))
    for mode in MODES:
        row = table.row(environment="free", mode=mode)
        table.counts(row, unit_of_analysis="trials of P01", n=4, trials=4, trials_with_value=4)
        table.numbers(row, {"mean_s": means[mode]}, DIGITS)
    table.nulls("one trial per session and mode tells no scatter within sessions", ["sd_s", "ci_low_s", "ci_high_s"])
    table.closed()


def of_contrasts(table, means):
    equal(f"{table.label}: rows", len(table.frame), len(CONTRASTS))
    for mode, against in CONTRASTS:
        row = table.row(environment="free", contrast=f"{mode} − {against}")
        table.counts(row, unit_of_analysis="trials of P01", n=8, sessions=4, verdict="not tested", remark=NOT_DRAWN)
        expect = {"mean_first_s": means[mode], "mean_second_s": means[against], "difference_s": means[mode] - means[against]}
        table.numbers(row, expect, DIGITS)
    welch = ["difference_std_error_s", "difference_ci_low_s", "difference_ci_high_s", "df"]
    table.nulls("Welch's interval takes two trials per session and mode", welch)
    table.nulls("the orders are not this program's", ["p_sharp_null", "p_adjusted", "smallest_p_adjusted"])
    table.closed()


def of_orders(table):
    effects = ["any effect", *(f"{mode} − {against}" for mode, against in CONTRASTS)]
    equal(f"{table.label}: rows", table.frame["effect"].tolist(), effects)
    for effect in effects:
        table.counts(table.row(environment="free", effect=effect), sessions=4, trials=12, remark=NOT_DRAWN)
    table.nulls("the orders are not this program's", ["p_value", "smallest_p"])
    table.closed()


def of_participants(table, means):
    equal(f"{table.label}: rows", len(table.frame), len(CONTRASTS))
    for mode, against in CONTRASTS:
        row = table.row(environment="free", contrast=f"{mode} − {against}", participant="P01")
        table.counts(row, sessions=4, trials_first=4, trials_second=4)
        table.numbers(row, {"difference_s": means[mode] - means[against]}, DIGITS)
    welch = ["difference_std_error_s", "difference_ci_low_s", "difference_ci_high_s"]
    table.nulls("Welch's interval takes two trials per session and mode", welch)
    table.closed()


def of_sessions(table, durations):
    equal(f"{table.label}: rows", len(table.frame), len(MODES) * (len(SESSIONS) - 1))
    first = SESSIONS[0]
    for mode in MODES:
        for later in SESSIONS[1:]:
            row = table.row(environment="free", mode=mode, sessions=f"{later} − {first}")
            table.counts(row, n=1)
            expect = {"mean_later_s": durations[later, mode], "mean_earlier_s": durations[first, mode]}
            table.numbers(row, expect, DIGITS)
    there = ["environment", "mode", "sessions", "n", "mean_later_s", "mean_earlier_s", "remark"]
    table.nulls("changes and agreement of sessions take two participants", [c for c in table.frame if c not in there])
    table.closed()


def of_repeats(table):
    equal(f"{table.label}: rows", len(table.frame), len(MODES))
    for mode in MODES:
        table.counts(table.row(environment="free", mode=mode), unit_of_analysis="trials of P01", n=4)
    rest = [c for c in table.frame if c.startswith("change") or c in ["df", "p_value"]]
    table.nulls("one repeat has no change to a next one", rest)
    table.closed()


def sentences(root, notes):
    """With one participant nothing is said of people."""
    summary = (root / "reports/ethz/summary.md").read_text()
    lines = [line for line in summary.splitlines() if "differ" in line] + notes
    check("ethz: sentences on differences", len(lines) > 4, lines)
    alone = ["Every number here describes this one participant and nobody else.", "Nothing is said of anybody else."]
    equal("ethz: the summary says of whom it speaks", [words for words in alone if words not in summary], [])
    # No trial has the default primary metric, and no contrast a test.
    untested = "it was not tested whether the modes differ in duration, from onset to end (exploratory: not the primary metric)"
    check("ethz: the summary says that nothing was tested, and that it is not the primary metric", untested in summary, lines)
    general = [line for line in lines if "participants" in line or "people" in line]
    equal("ethz: sentences on people in general", general, [])
