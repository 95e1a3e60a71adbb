"""The progress on stderr: never silent for long, honest about shares, gone where nobody looks."""

from __future__ import annotations

import io
import sys
import time
from collections.abc import Callable

import pytest

from inverse.cli import terminal
from inverse.cli.terminal import ProgressLine


class Screen(io.StringIO):
    def isatty(self) -> bool:
        return True


class Closed(io.StringIO):
    def write(self, _: str) -> int:
        raise BrokenPipeError


def until(true: Callable[[], bool], within_s: float = 10.0) -> bool:
    end = time.monotonic() + within_s
    while not true() and time.monotonic() < end:
        time.sleep(0.01)
    return true()


def test_a_long_work_that_tells_nothing_new_is_shown_with_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    with ProgressLine(pulse_s=0.05) as line:
        line.phase("drawing design.png")
        assert screen.getvalue().endswith("drawing design.png")
        line._told -= 20.0
        assert until(lambda: screen.getvalue().endswith("drawing design.png (20 s)"))
    assert screen.getvalue().endswith("\r\033[K")


def test_a_log_gets_whole_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    log = io.StringIO()
    monkeypatch.setattr(sys, "stderr", log)
    with ProgressLine(every_s=0.0, pulse_s=100.0) as line:
        line.show("iteration 1")
        line.show("iteration 2")
    assert log.getvalue() == "iteration 1\niteration 2\n"


def test_nothing_waits_longer_than_fifteen_seconds() -> None:
    assert max(terminal.PULSE_S, terminal.LOG_PULSE_S) * 1.25 < 15


def test_shares_and_the_time_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    log, clock = io.StringIO(), [0.0]
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    line = ProgressLine(every_s=0.0, pulse_s=1e6)
    line.share("drawing frames", 0, 8)
    clock[0] = 10.0
    line.share("drawing frames", 2, 8)
    clock[0] = 1000.0
    line.share("writing", 1, 2)  # another work, whose time is not known yet
    line.share("looking", 0, 0)  # how much there is is not known
    assert log.getvalue().splitlines() == [
        "drawing frames: 0 of 8, 0 %",
        "drawing frames: 2 of 8, 25 %, 30 s left",
        "writing: 1 of 2, 50 %",
        "looking",
    ]


def test_lines_fit_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is wrapped cannot be taken back by a carriage return."""
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "20")
    with ProgressLine(pulse_s=100.0) as line:
        line.phase("x" * 50)
        assert screen.getvalue() == "\r\033[K" + "x" * 19


def test_a_reader_who_is_gone_ends_no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Closed())
    with ProgressLine(every_s=0.0) as line:
        line.show("iteration 1")


@pytest.mark.parametrize(("seconds", "words"), [(0.4, "0 s"), (99.4, "99 s"), (200, "3 min 20 s"), (7500, "2 h 5 min")])
def test_times(seconds: float, words: str) -> None:
    assert terminal._seconds(seconds) == words
