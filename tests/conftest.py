"""Puts this folder on the path, so that tests share its generators of truth; a part of the tests; what was skipped."""

import os
import random
from collections import Counter

import pytest

# As the command line does: threads of BLAS cost more than they give on small matrices, most of all side by side.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ALL = "METROLOGY_TEST_ALL"
"""Set by `make test-all`: a skipped test is then a failure."""


def pytest_addoption(parser) -> None:
    parser.addoption("--part", type=float, default=1.0, help="share of the tests to run, drawn by --part-seed")
    parser.addoption("--long", type=float, default=1.0, help="share of those that are marked long")
    parser.addoption("--part-seed", default="1")


def pytest_collection_modifyitems(config, items) -> None:
    """Keep a part of the tests: the same one wherever it is drawn, whatever the order of collection."""
    share, long, seed = (config.getoption(name) for name in ("--part", "--long", "--part-seed"))
    left_out = set()
    for item in items:
        wanted = share * long if item.get_closest_marker("long") else share
        if random.Random(f"{seed} {item.nodeid}").random() >= wanted:
            left_out.add(item)
    if left_out:
        config.hook.pytest_deselected(items=list(left_out))
        items[:] = [item for item in items if item not in left_out]
    # The long ones first: at the end no process waits for another one's.
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


def _reasons(reporter) -> Counter[str]:
    reports = reporter.stats.get("skipped", [])
    return Counter(report.longrepr[2].removeprefix("Skipped: ") for report in reports)


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter) -> None:
    """One line for all skipped tests: why, and the command that brings what is missing."""
    reasons = _reasons(terminalreporter)
    if not reasons:
        return
    why = "; ".join(f"{reason} ({count})" for reason, count in sorted(reasons.items()))
    terminalreporter.write_line(
        f"{sum(reasons.values())} tests skipped: {why}. On Debian, as root, `make test-all` installs Chromium, Java "
        "and SoftHSM and skips nothing."
    )


def pytest_sessionfinish(session, exitstatus) -> None:
    """Fail a run of `make test-all` in which a test was skipped."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get(ALL) and reporter is not None and exitstatus == 0 and _reasons(reporter):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
