"""PsychoPy's handlers and psignifit on the people of people.rs.

    python peer.py fits ANSWERS.csv                 seconds a fit, then threshold and the ends of its interval, a line each
    python peer.py trials PEOPLE TRIALS EVERY       errors after every so many trials, a line for each handler and person
"""

import math
import sys
import time
import warnings

import numpy as np

warnings.simplefilter("ignore")


def without_words():
    """PsychoPy prints remarks among what is asked for."""
    from psychopy import logging

    logging.console.setLevel(logging.CRITICAL + 1)


MASK = (1 << 64) - 1


def uniform(person, trial):
    mixed = ((((person << 32) | trial) + 1) * 0x9E3779B97F4A7C15) & MASK
    mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & MASK
    return ((mixed ^ (mixed >> 31)) >> 11) / 2**53


def fits(file):
    import psignifit

    rows = [[float(cell) for cell in line.split(",")] for line in open(file)]
    data = [np.reshape(row, (-1, 3)) for row in rows]
    psignifit.psignifit(data[0], experiment_type="equal asymptote", sigmoid="norm", fixed_parameters={"eta": 0.0}, verbose=False)
    began = time.perf_counter()
    found = [psignifit.psignifit(own, experiment_type="equal asymptote", sigmoid="norm", fixed_parameters={"eta": 0.0}, verbose=False) for own in data]
    print((time.perf_counter() - began) / len(data))
    for own in found:
        low, high = own.confidence_intervals["threshold"]["0.95"]
        print(own.parameter_estimate_mean["threshold"], low, high, sep="\t")


class Person:
    lapse, slope = 0.02, 2.0

    def __init__(self, number):
        self.number = number
        self.alpha = 0.08 * math.exp(0.8 * (uniform(number, 0) - 0.5))

    def share(self, level):
        return 0.5 + (0.5 - self.lapse) * -math.expm1(-((level / self.alpha) ** self.slope))

    def is_right(self, trial, level):
        return uniform(self.number, 10 + trial) < self.share(level)

    def level_at(self, share):
        return self.alpha * (-math.log1p(-(share - 0.5) / (0.5 - self.lapse))) ** (1 / self.slope)

    def threshold(self):
        return self.alpha * math.log(2) ** (1 / self.slope)


def stair(downs, share):
    """Equal steps in dB, as the handler comes; its guide takes the mean of the last reversals."""
    from psychopy.data import StairHandler

    def run(person, trials, every):
        handler = StairHandler(startVal=0.24, nReversals=trials, nTrials=trials, stepSizes=[2, 2, 1], stepType="db", nUp=1, nDown=downs, minVal=0.005, maxVal=0.5)
        for trial in range(trials):
            handler.addResponse(int(person.is_right(trial, next(handler))))
            if (trial + 1) % every == 0:
                later = handler.reversalIntensities[2:]
                yield abs(math.exp(np.mean(np.log(later))) / person.level_at(share) - 1) if len(later) > 1 else ""

    return run


def quest(person, trials, every):
    """QUEST in log10 of the level; its threshold is that of 82 % right."""
    from psychopy.data import QuestHandler

    handler = QuestHandler(math.log10(0.24), 0.5, pThreshold=0.82, gamma=0.5, delta=0.02, beta=2.0, grain=0.01, range=3, nTrials=trials, method="mean", minVal=math.log10(0.005), maxVal=math.log10(0.5))
    for trial in range(trials):
        handler.addResponse(int(person.is_right(trial, 10 ** next(handler))))
        if (trial + 1) % every == 0:
            yield abs(10 ** handler.mean() / person.level_at(0.82) - 1)


def quest_plus(person, trials, every):
    from psychopy.data import QuestPlusHandler

    levels = np.log10(np.round(0.02 * 10 ** (np.arange(25) / 20), 6))
    handler = QuestPlusHandler(
        nTrials=trials, intensityVals=levels, thresholdVals=levels, slopeVals=[1, 1.5, 2, 2.5, 3, 4, 5], lowerAsymptoteVals=[0.5],
        lapseRateVals=[0.02], responseVals=["Yes", "No"], stimScale="log10", paramEstimationMethod="mean",
    )
    for trial in range(trials):
        handler.addResponse("Yes" if person.is_right(trial, 10 ** next(handler)) else "No")
        if (trial + 1) % every == 0:
            found = handler.paramEstimate
            # Its threshold is alpha, at F = 1 - 1/e.
            yield abs(10 ** found["threshold"] * math.log(2) ** (1 / found["slope"]) / person.threshold() - 1)


def main():
    if sys.argv[1] == "fits":
        return fits(sys.argv[2])
    without_words()
    people, trials, every = map(int, sys.argv[2:5])
    # Where equal steps of one up and two or three down balance: 1/2 to the power of 1/2, or 1/3.
    handlers = [
        ("PsychoPy: StairHandler, 1 up 2 down", stair(2, 0.5 ** (1 / 2))), ("PsychoPy: StairHandler, 1 up 3 down", stair(3, 0.5 ** (1 / 3))),
        ("PsychoPy: QuestHandler", quest), ("PsychoPy: QuestPlusHandler", quest_plus),
    ]
    for name, run in handlers:
        for number in range(people):
            print(name, *run(Person(number), trials, every), sep="\t")


main()
