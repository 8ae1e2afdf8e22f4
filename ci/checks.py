"""Counts what was checked; shared by the checks of our files."""

import sys

passed, failed = 0, 0


def check(path, what, ok, detail=""):
    global passed, failed
    if ok:
        passed += 1
    else:
        failed += 1
        print(f"FAILED {path}: {what} {detail}")


def finish():
    """Prints the counts and ends the program: with 1 if anything failed or there was nothing to check."""
    print(f"{passed} passed, {failed} failed")
    sys.exit(0 if failed == 0 and passed > 1 else 1)
