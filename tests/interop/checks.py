"""One line a check, and a count at the end."""

import subprocess
import sys

passed = 0
failed = 0
# Numbers computed twice that must agree to this or closer: how many, and the largest relative difference with its name.
SAME = 3e-6
compared = 0
worst = (0.0, "none")


def check(what, ok, detail=""):
    """Counts a check and prints its line; `detail` says what was found where it fails."""
    global passed, failed
    if ok:
        passed += 1
        print(f"ok    {what}")
    else:
        failed += 1
        print(f"FAIL  {what}: {detail}")


def equal(what, found, expect):
    """Checks that two values are equal."""
    check(what, found == expect, f"{found!r} is not {expect!r}")


def close(what, found, expect, relative):
    """Checks that two numbers agree to a relative tolerance."""
    global compared, worst
    if relative <= SAME:
        compared += 1
        worst = max(worst, (abs(found - expect) / abs(expect) if expect else abs(found), what))
    check(what, abs(found - expect) <= relative * abs(expect), f"{found!r} is not {expect!r} to {relative:g}")


def end():
    """Prints the closing line; the exit code says whether a check failed."""
    if compared:
        print(f"{compared} numbers computed twice: largest relative difference {worst[0]:.1e} ({worst[1]})")
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed or not passed else 0)


DONE = (0,)
DONE_OR_WITH_CARE = (0, 3)


def run(program, *arguments, codes=DONE):
    """Runs the program, which ends with one of these codes; what it prints."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in codes:
        raise SystemExit(f"zwidth {' '.join(map(str, arguments))} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout
