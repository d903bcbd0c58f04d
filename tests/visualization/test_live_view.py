"""Live view, as a browser would ask it: the same frames as the replay's, from the start, up to the end."""

from __future__ import annotations

import http.client
import json
import socket
import urllib.request
from urllib.error import HTTPError

import numpy as np
import pytest
from simple_flight import fly, write_stretch

from doorman.exceptions import DoormanError
from doorman.recording import Recorder
from doorman.visualization import LiveView
from doorman.visualization.scene.drawing import Drawing
from doorman.visualization.scene.moments import recorded_moments


def events(view):
    """Frames that were sent, and the name of the last event."""
    with urllib.request.urlopen(f"{view.url}frames", timeout=60) as answer:
        blocks = answer.read().decode().strip().split("\n\n")
    frames = [frame for block in blocks if block.startswith("data: ") for frame in json.loads(block[6:])]
    return frames, blocks[-1]


def port_of(view):
    return int(view.url.rsplit(":", 1)[1][:-1])


def test_frames_are_those_of_the_replay(model):
    with LiveView(model, "live") as view, Recorder(None, {}, view.listen) as recorder:
        write_stretch(model, recorder, 0.0, 1.0)
        assert not view.end(patience=0.0)
        first, last = events(view)
        again, _ = events(view)
        assert last.startswith("event: end") and again == first
        assert view.end(patience=60.0)
    replayed = [Drawing(model).frame(moment) for moment in recorded_moments(recorder.recording())]
    assert len(first) == pytest.approx(len(replayed), abs=1)
    for frame in first[::10]:
        nearest = min(replayed, key=lambda other: abs(other["time"] - frame["time"]))
        np.testing.assert_allclose(frame["poses"], nearest["poses"], atol=0.02)  # up to 1/60 s apart
        assert frame["phase"] in ("touch", "open") and len(frame["clearances"]) == 4


def test_a_flight_without_truth_is_shown_by_its_estimate(model):
    recording = fly(model, 0.5, with_truth=False)
    with LiveView(model, "live") as view:
        for topic in ("measurement", "estimate"):
            fields = {name: recording[topic][name][0] for name in recording[topic]}
            view.listen(topic, 0.0, fields)
        view.listen("estimate", 0.1, {"state": fields["state"] * np.nan})  # the first tick's pose, a broken angle
        view.end()
        (frame,), _ = events(view)
    assert frame["door_angle"] == pytest.approx(np.degrees(recording["estimate"]["state"][0, 3]), abs=0.01)


def test_nothing_else_is_served(model):
    with LiveView(model, "live") as view:
        assert view.url.startswith("http://127.0.0.1:")
        with pytest.raises(HTTPError, match="404"):
            urllib.request.urlopen(f"{view.url}../etc/passwd", timeout=60)
        with pytest.raises(DoormanError, match="port"), LiveView(model, "another", port_of(view)):
            pass
    with pytest.raises(DoormanError, match="not open"):
        view.url  # noqa: B018


def ask(view, path="/", **headers):
    """Status and headers of an answer to a request with exactly these headers."""
    with socket.create_connection(("127.0.0.1", port_of(view)), timeout=60) as connection:
        lines = [f"GET {path} HTTP/1.0", *(f"{name.replace('_', '-')}: {value}" for name, value in headers.items())]
        connection.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        with connection.makefile("rb") as answer:
            head = answer.readline().decode(), http.client.parse_headers(answer)
            return int(head[0].split()[1]), head[1]


def test_only_its_own_page_gets_an_answer(model):
    with LiveView(model, "live") as view:
        view.end()
        host = view.url.removeprefix("http://").rstrip("/")
        tunnel = "localhost:7000"
        for path in ("/", "/frames"):
            for headers in (
                {"Host": host},
                {"Host": host, "Origin": f"http://{host}", "Sec_Fetch_Site": "same-origin", "Sec_Fetch_Dest": "empty"},
                {"Host": tunnel, "Origin": f"http://{tunnel}"},
                {"Host": "[::1]:7000"},
                {"Host": "LOCALHOST"},
                {"Host": host, "Sec_Fetch_Site": "cross-site", "Sec_Fetch_Dest": "document"},  # a link was followed
            ):
                assert ask(view, path, **headers)[0] == 200, headers
            for headers in (
                {},
                {"Host": "evil.example"},
                {"Host": f"evil.example:{host.rsplit(':', 1)[1]}"},
                {"Host": f"{host}.evil.example"},
                {"Host": "127.0.0.1.evil.example"},
                {"Host": "evil.example#127.0.0.1"},
                {"Host": host, "Origin": "http://evil.example"},
                {"Host": host, "Origin": "null"},
                {"Host": host, "Origin": f"https://{host}"},
                {"Host": host, "Origin": "http://127.0.0.1:1"},
                {"Host": f"{host}\r\nHost: evil.example"},
                {"Host": host, "Sec_Fetch_Site": "cross-site", "Sec_Fetch_Dest": "iframe"},
                {"Host": host, "Sec_Fetch_Site": "cross-site", "Sec_Fetch_Dest": "script"},
                {"Host": host, "Origin": "http://evil.example", "Upgrade": "websocket", "Connection": "Upgrade"},
            ):
                assert ask(view, path, **headers)[0] == 403, headers
        _, answer = ask(view, Host=host)
        assert answer["X-Frame-Options"] == "DENY" and "Access-Control-Allow-Origin" not in answer


def test_a_hostile_name_and_message_stay_words(model):
    hostile = "</script><script>alert(1)</script><!-- <script>"
    with LiveView(model, hostile) as view:
        with urllib.request.urlopen(view.url, timeout=60) as answer:
            text = answer.read().decode()
        view.listen("mission", 0.0, {"state": "open", "message": f"{hostile}\n\nevent: end"})
        fields = {"position": np.zeros(3), "attitude": np.zeros(3), "door_angle": 1.0, "arm_angles": model.start_arm}
        view.listen("truth", 0.0, fields)
        view.end()
        (frame,), _ = events(view)
    assert "alert(1)" in text and "<script>alert" not in text and "</script><script>a" not in text
    assert frame["reason"] == f"{hostile}\n\nevent: end"
