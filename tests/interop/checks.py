"""One line a check, and a count at the end."""

import subprocess
import sys

passed = 0
failed = 0


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
    check(what, abs(found - expect) <= relative * abs(expect), f"{found!r} is not {expect!r} to {relative:g}")


def end():
    """Prints the closing line; the exit code says whether a check failed."""
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed or not passed else 0)


def run(program, *arguments):
    """Runs the program; what it prints."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"zwidth {' '.join(map(str, arguments))} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout
