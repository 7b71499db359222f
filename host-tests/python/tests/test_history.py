"""The history of a calibrator."""

from __future__ import annotations

import json
import pickle

import numpy as np

import stereo_selfcal as sc

from .conftest import Made, make_rig, rotation


def drive(calibrator: sc.Calibrator, history: sc.History, made: Made, pairs: range) -> None:
    for pair in pairs:
        if calibrator.fuse(*made.pair(pair)).verdict.should_apply:
            calibrator.apply()
        history.note(calibrator, time=100 * pair)


def test_a_history_tells_the_lock_and_the_knock(made: Made) -> None:
    calibrator, history = sc.Calibrator(made.rig), sc.History()
    drive(calibrator, history, made, range(12))
    before = history.events
    assert [event.state for event in before if "state" in event.changes] == ["locked"]
    assert before[-1].generation == calibrator.generation == 1
    knocked = make_rig(rotation(0.02, 0, 0) @ made.R, made.t)
    drive(calibrator, history, knocked, range(12, 24))
    states = [event.state for event in history.events if event.pair >= 12 and "state" in event.changes]
    assert states[0] == "suspect" and states[-1] == "locked" and calibrator.generation == 2
    assert all(event.time == 100 * event.pair for event in history.events)


def test_an_event_is_a_line_of_json_and_can_be_pickled(made: Made) -> None:
    calibrator, history = sc.Calibrator(made.rig), sc.History()
    drive(calibrator, history, made, range(8))
    event = history.events[-1]
    copy = pickle.loads(pickle.dumps(event))
    assert (copy.json, copy.text, copy.changes) == (event.json, event.text, event.changes)
    fields = json.loads(event.json)
    assert fields["time"] == event.time and fields["pair"] == event.pair
    assert fields["changes"] == list(event.changes) and fields["may_arm"] == event.verdict.may_arm
    assert len(fields["reasons"]) == len(event.verdict.reasons)
    assert all(reason in event.verdict.text for reason in fields["reasons"])
    np.testing.assert_allclose(fields["rows_px"], event.verdict.rows_px)


def test_a_full_history_keeps_the_last_events(made: Made) -> None:
    calibrator, history, whole = sc.Calibrator(made.rig), sc.History(2), sc.History()
    for pair in range(8):
        if calibrator.fuse(*made.pair(pair)).verdict.should_apply:
            calibrator.apply()
        first, second = (one.note(calibrator, pair=pair) for one in (history, whole))
        assert (first is None) == (second is None)
    assert len(whole.events) > 2 and history.capacity == 2
    assert [event.text for event in history.events] == [event.text for event in whole.events[-2:]]
    assert history.note(calibrator) is None
