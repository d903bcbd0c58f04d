"""The pages in a real browser: they load, show what they should, and the door moves when the time does."""

from __future__ import annotations

import math
import re
from contextlib import contextmanager

import numpy as np
import pytest
from browser import Browser
from simple_flight import write_stretch

from doorman.recording import Recorder
from doorman.visualization import LiveView, replay_page


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("browser"))
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def address(flight, model, tmp_path_factory):
    return replay_page(flight, model, tmp_path_factory.mktemp("page") / "replay.html").as_uri()


@pytest.fixture(scope="module")
def loaded(browser, address):
    """The replay, loaded once, at the time that its address says."""
    browser.open(f"{address}#t=1")
    assert browser.evaluate("[time, playing]") == [1, False]
    return browser


@pytest.fixture
def page(loaded):
    """The replay, stopped at its beginning."""
    loaded.evaluate("seek(0); speed.value = '1'; shown = null")
    loaded.settle()
    yield loaded
    assert loaded.errors == []


def wooden(picture):
    """Where the picture shows the door's brown."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return (red > green + 15) & (green > blue + 15) & (red < 235)


def shown_angle(page):
    """Angle of the leaf as it stands in the scene [deg]."""
    x, y = page.evaluate("(({elements: m}) => [m[0], m[1]])(node('scene/door/leaf').matrix)")
    return math.degrees(math.atan2(y, x))


def recorded_angle(flight, time):
    return math.degrees(np.interp(time, flight["truth"].time, flight["truth"]["door_angle"]))


def share_that_changes(page, change, back):
    """Share of the picture that a change of the scene touches."""
    before = page.picture()
    page.evaluate(f"{change}; viewer.set_dirty()")
    page.settle()
    after = page.picture()
    page.evaluate(f"{back}; viewer.set_dirty()")
    page.settle()
    assert np.abs(page.picture() - before).max() <= 2
    return (np.abs(after - before).max(axis=-1) > 8).mean()


def leaf_share(page):
    """Share of the picture that the leaf covers; less, the farther it stands open."""
    leaf = "node('scene/door/leaf').visible"
    return share_that_changes(page, f"{leaf} = false", f"{leaf} = true")


@contextmanager
def phone(browser):
    """The page on a screen of 390 × 844 points, upright."""
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    browser.settle()
    yield
    browser.call("Emulation.clearDeviceMetricsOverride")
    browser.settle()


def assert_fits_a_phone(browser):
    """Nothing runs over the screen or over another text, and letters are large enough."""
    assert browser.evaluate("[innerWidth, document.documentElement.scrollWidth]") == [390, 390]
    boxes = browser.evaluate(
        "['caption', 'legend', 'controls'].map(id => document.getElementById(id).getBoundingClientRect())"
        ".map(({left, top, right, bottom}) => [left, top, right, bottom])"
    )
    for left, top, right, bottom in boxes:
        assert 0.0 <= left < right <= 390.0 and 0.0 <= top < bottom <= 844.0
    assert boxes[0][3] < boxes[1][1] and boxes[1][3] < boxes[2][1], "one below the other"
    inside = browser.evaluate(
        "[...document.querySelectorAll('#controls > *, #legend td')].filter(one => one.offsetWidth)"
        ".map(one => [one.getBoundingClientRect().right, parseFloat(getComputedStyle(one).fontSize)])"
    )
    assert len(inside) > 10 and all(right <= 390.0 and size >= 13.0 for right, size in inside)


def test_the_page_fits_a_phone(page):
    page.click("#surfaces")
    with phone(page):
        assert_fits_a_phone(page)
    page.click("#surfaces")


def test_the_page_shows_vehicle_and_door(page):
    picture = page.picture()
    assert wooden(picture).mean() > 0.1
    assert share_that_changes(page, "world.visible = false", "world.visible = true") > 0.25
    for node, least in (("vehicle", 0.01), ("door", 0.2), ("vehicle/servo_3", 1e-4), ("door/frame", 0.05)):
        name = f"node('scene/{node}').visible"
        assert share_that_changes(page, f"{name} = false", f"{name} = true") > least, node
    assert "doorman: paper" in page.evaluate("document.body.innerText")


def test_the_door_moves_when_the_time_is_dragged(page, flight):
    closed, closed_angle, closed_share = page.picture(), shown_angle(page), leaf_share(page)
    assert closed_angle == pytest.approx(90.0, abs=0.1)
    page.click("#moment", 0.8)
    time = page.evaluate("time")
    assert 3.5 < time < 4.5 and not page.evaluate("playing")
    assert shown_angle(page) == pytest.approx(recorded_angle(flight, time), abs=0.3)
    said = float(re.search(r"door at ([\d.]+)°", page.evaluate("document.body.innerText"))[1])
    assert said == pytest.approx(recorded_angle(flight, time), abs=1.0)
    assert leaf_share(page) < 0.85 * closed_share
    opened = page.picture()
    assert (np.abs(opened - closed).max(axis=-1) > 8).mean() > 0.1
    page.click("#moment", 0.0)
    assert shown_angle(page) == pytest.approx(closed_angle, abs=0.1)
    assert (np.abs(page.picture() - closed).max(axis=-1) > 8).mean() < 0.01


def test_play_pause_and_speed(page):
    def pace():
        """Of the shown time against the clock; over two frames, since frames are slow without a graphics card."""
        page.evaluate("time = 0")
        page.settle()
        start, clock = page.evaluate("[time, before]")
        page.settle()
        end, later = page.evaluate("[time, before]")
        return (end - start) / (later - clock) * 1e3

    assert pace() == 0.0
    turned = page.evaluate("rotors[0][0].rotation.z")
    page.evaluate("speed.value = '0.25'")
    page.click("#toggle")
    assert page.evaluate("toggle.textContent") == "Pause" and pace() == pytest.approx(0.25)
    assert page.evaluate("rotors[0][0].rotation.z") != turned
    page.evaluate("speed.value = '0.1'")
    assert pace() == pytest.approx(0.1)
    page.click("#toggle")
    assert pace() == 0.0


def test_ribbon_force_and_trace_are_seen(page):
    page.click("#moment", 0.15)
    for name, least in (("ribbon", 1e-3), ("arrow", 2e-4), ("trace", 1e-5)):
        assert page.evaluate(f"{name}.visible")
        assert share_that_changes(page, f"{name}.visible = false", f"{name}.visible = true") > least, name
    dots = page.evaluate("trace.count")
    page.click("#moment", 0.8)
    assert page.evaluate("trace.count") > dots > 0


def test_a_wall_fades_only_where_it_hides_the_vehicle(page):
    opacities = "showVehicleThroughWalls(), walls.map(({material}) => material.opacity)"
    before = page.evaluate("viewer.camera.position.toArray()")
    assert page.evaluate("walls.length") > 0 and set(page.evaluate(opacities)) == {1}
    page.evaluate("""(() => {
        const middle = new THREE.Box3().setFromObject(walls[0]).getCenter(new THREE.Vector3());
        const vehicle = node("scene/vehicle").getWorldPosition(new THREE.Vector3());
        const behind = middle.clone().multiplyScalar(2).sub(vehicle);
        viewer.camera.position.copy(viewer.camera.parent.worldToLocal(behind));
        viewer.camera.updateMatrixWorld();
    })()""")
    seen = page.evaluate(opacities)
    page.evaluate(f"viewer.camera.position.set(...{before}), viewer.camera.updateMatrixWorld()")
    assert seen[0] < 0.5
    assert set(page.evaluate(opacities)) == {1}


def test_the_vehicle_casts_a_shadow(page):
    assert share_that_changes(page, "sun.castShadow = false", "sun.castShadow = true") > 1e-3


def test_surfaces_are_seen_when_they_are_asked_for(page):
    def change():
        return share_that_changes(page, "surfaces[0].material.visible = false", "surfaces[0].material.visible = true")

    assert change() == 0.0 and not page.evaluate("legend.offsetHeight")
    page.click("#surfaces")
    assert change() > 1e-3 and page.evaluate("legend.offsetHeight") > 0
    page.click("#surfaces")
    assert change() == 0.0


def test_surfaces_turn_red_where_nothing_is_left(page):
    page.evaluate("showSurfaces(true)")
    red = "#D55E00"
    for index in range(4):
        clearances = [1.0] * 4
        clearances[index] = -0.01
        page.evaluate(f"showClearances({clearances}); viewer.set_dirty()")
        colors = page.evaluate("surfaces.map(({material}) => '#' + material.color.getHexString().toUpperCase())")
        assert [color == red for color in colors] == [k == index for k in range(4)]
        where = f"showClearances({[1.0] * 4})"
        assert share_that_changes(page, where, f"showClearances({clearances})") > 1e-3, index


def test_a_flight_is_seen_while_it_is_flown(browser, model):
    with LiveView(model, "live") as view, Recorder(None, {}, view.listen) as recorder:
        write_stretch(model, recorder, 0.0, 1.0)
        browser.open(view.url)
        browser.wait_for(lambda: browser.evaluate("frames.length") >= 30, "the frames so far")
        browser.settle()
        first = shown_angle(browser)
        assert "open" in browser.evaluate("document.getElementById('phase').textContent")
        browser.evaluate("showSurfaces(true)")
        with phone(browser):
            assert_fits_a_phone(browser)
        browser.evaluate("showSurfaces(false)")
        write_stretch(model, recorder, 1.0, 3.0)
        browser.wait_for(lambda: browser.evaluate("frames[frames.length - 1].time") > 2.9, "the frames of the flight")
        browser.settle()
        assert shown_angle(browser) < first - 20.0  # it follows by itself
        browser.click("#moment", 0.0)
        assert shown_angle(browser) == pytest.approx(90.0, abs=0.5)
        assert view.end(patience=60.0)
        browser.wait_for(lambda: browser.evaluate("follow.hidden"), "the end of the flight")
    browser.click("#moment", 0.97)
    assert shown_angle(browser) < first - 20.0  # the page outlives the flight
    assert browser.errors == []
    assert wooden(browser.picture()).mean() > 0.1
