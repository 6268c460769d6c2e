"""The figure that the reader drags shows the frames that were computed, and nothing else."""

import json
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy import cos, sin

from mechlib.moving import WORDS, Arrows, Moving, Quantity

STATIC = Path(__file__).parents[1] / "book" / "_static"

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A section 5.2

THEMES = {"light": "#fff", "dark": "#121212"}  # the backgrounds of the book


def e(angle):
    return np.stack((cos(angle), sin(angle)), axis=-1)


def hacksaw(frames=360, **change):
    th2 = 2 * np.pi * np.arange(frames) / frames
    th3 = np.pi - np.arcsin((R1Y - R2 * sin(th2)) / R3)
    a = R2 * e(th2)
    b = a + R3 * e(th3)
    numbers = [Quantity(name, 100 * sin(th2 + k), "mm/s", 3) for k, name in enumerate(("a", "b", "c", "d", "e"))]
    saw = Moving(
        joints={"O": (0, 0), "A": a, "B": b},
        bodies={"crank": "OA", "coupler": "AB"},
        input=Quantity("θ₂", np.rad2deg(th2), "°"),
        alt="A crank turns about O and drives the slider B along a straight guide.",
        cyclic=True,
        values=[Quantity("θ₃", np.rad2deg(th3), "°", 1), *numbers],
        ground="O",
        sliders={"B": (1, 0)},
        arrows=[Arrows("velocity at 1 rad/s", {"A": R2 * e(th2 + np.pi / 2)}, "m/s")],
        start=40,
    )
    return replace(saw, **change)


def cylinder():
    """A rocker lifted by a cylinder: an input that does not come round."""
    turn = np.deg2rad(np.linspace(-35, 35, 80))
    joint, base = 0.25 * e(turn), np.array([0.25, -1.0])
    stroke = np.linalg.norm(joint - base, axis=1)
    along = (joint - base) / stroke[:, None]
    return Moving(
        joints={"O": (0, 0), "D": base, "J": joint, "_end": base + 0.75 * along, "_piston": joint - 0.4 * along},
        bodies={"barrel": ("D", "_end"), "rod": ("_piston", "J"), "rocker": "OJ"},
        input=Quantity("s", stroke, "m", 3),
        alt="A cylinder lifts a rocker.",
        ground="OD",
        barrels=["barrel"],
    )


def data(moving):
    return json.loads(re.search(r"<script[^>]*>(.*)</script>", moving._repr_html_()).group(1))


# What is written


def test_a_frame_in_which_the_linkage_cannot_close_is_refused_by_its_index():
    joints = dict(hacksaw().joints)
    joints["B"] = joints["B"].copy()
    joints["B"][17, 0] = np.nan
    with pytest.raises(
        ValueError, match=r"joint 'B' must be finite, got \[.*nan.*\] at index 17; leave out the frames"
    ):
        hacksaw(joints=joints)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"joints": {"O": (0, 0), "A": np.ones((359, 2))}}, r"joint 'A' must have the shape \(360, 2\) or \(2,\), got"),
        ({"joints": {"pin A": (0, 0)}}, "name of a joint must be one word, got 'pin A'"),
        ({"bodies": {"rocker": "BC"}}, "body 'rocker' has the unknown joint 'C'; known are O, A, B"),
        ({"bodies": {"rocker": "B"}}, "body 'rocker' needs two joints or more, got 1"),
        ({"ground": "X"}, "ground has the unknown joint 'X'"),
        ({"ground": "A"}, "ground has the joint 'A', which moves"),
        ({"traces": ["P"]}, "traces has the unknown joint 'P'"),
        ({"sliders": {"C": (1, 0)}}, "sliders has the unknown joint 'C'"),
        ({"sliders": {"B": (0, 0)}}, r"direction of slider 'B' must not be zero, got \(0, 0\)"),
        ({"barrels": ["rod"]}, "barrels has the unknown body 'rod'; known are crank, coupler"),
        ({"cloud": [(0, np.inf)]}, "cloud must be finite, got .*inf.* at index 0"),
        ({"backdrop": [(0, 0, 1)]}, r"backdrop must have the shape \(1, 2\), got \(1, 3\)"),
        ({"arrows": [Arrows("force", {"C": np.ones((360, 2))})]}, "'force' has the unknown joint 'C'"),
        ({"arrows": [Arrows("force", {"A": np.ones(360)})]}, r"'force' at joint 'A' must have the shape \(360, 2\)"),
        ({"values": [Quantity("r₁", [1.0])]}, r"value 'r₁' must have the shape \(360,\), got \(1,\)"),
        ({"input": Quantity("θ₂", [0.0])}, "two frames or more, got 1"),
        ({"alt": " "}, "alt must say what the picture shows, got ' '"),
        ({"start": 360}, "start must be a frame from 0 to 359, got 360"),
        ({"seconds": 0}, "seconds must be positive, got 0"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_bad_input_is_refused_with_the_value_that_is_wrong(change, says):
    with pytest.raises(ValueError, match=says):
        hacksaw(**change)


def test_a_cyclic_motion_that_does_not_come_round_is_refused():
    with pytest.raises(ValueError, match=r"from the last frame to the first joint 'J' jumps 0\.287 m"):
        replace(cylinder(), cyclic=True)


def test_the_drawing_is_to_scale_in_every_frame():
    saw = hacksaw()
    drawn = saw.drawn()
    lengths = {pair: np.linalg.norm(drawn[pair[0]] - drawn[pair[1]], axis=1) for pair in ("OA", "AB")}
    scale = lengths["OA"][0] / R2
    np.testing.assert_allclose(lengths["OA"], R2 * scale, atol=0.03)  # both ends are rounded to 0.01
    np.testing.assert_allclose(lengths["AB"], R3 * scale, atol=0.05)
    np.testing.assert_allclose(drawn["B"][:, 1], drawn["O"][0, 1] - R1Y * scale, atol=0.03)  # y upwards is up


def test_the_frames_in_the_page_are_those_that_were_given():
    saw = hacksaw()
    page = data(saw)
    for name, path in saw.drawn().items():
        np.testing.assert_array_equal(page["joints"][name], path)
    assert page["values"][0] == [f"{k}°" for k in range(360)]
    assert page["values"][1][40] == f"{np.rad2deg(np.pi - np.arcsin((R1Y - R2 * sin(np.deg2rad(40))) / R3)):.1f}°"
    assert np.linalg.norm(page["arrows"][0]["vectors"]["A"], axis=1) == pytest.approx(np.full(360, 88), rel=0.2)


def test_the_still_is_the_start_frame():
    saw = hacksaw(start=123)
    html, drawn = saw._repr_html_(), saw.drawn()
    (x0, y0), (x1, y1) = drawn["O"][0], drawn["A"][123]
    assert f'data-chain="O A" points="{x0:g},{y0:g} {x1:g},{y1:g}"' in html
    assert "<dd>123°</dd>" in html
    assert repr(saw).endswith(f"θ₂ = 123°, {', '.join(f'{q.symbol} = {q.texts()[123]}' for q in saw.values)}.")


def test_every_position_and_every_arrow_fits_into_the_picture():
    for moving in (hacksaw(), cylinder()):
        width, height = map(float, re.search(r'viewBox="0 0 (\S+) (\S+)"', moving._repr_html_()).groups())
        points = np.concatenate(list(moving.drawn().values()))
        assert (points >= 40).all() and (points <= (width - 40, height - 40)).all()
    page = data(hacksaw())
    tips = np.add(page["joints"]["A"], page["arrows"][0]["vectors"]["A"])
    assert (tips > 40).all()


def test_what_lies_behind_is_drawn_to_the_same_scale_and_fits():
    corners = np.array([(-0.3, -0.1), (0.2, -0.1), (0.2, 0.15)])
    html = hacksaw(backdrop=corners)._repr_html_()
    pairs = re.search(r'class="backdrop" points="([^"]*)"', html).group(1).split()
    drawn = np.array([pair.split(",") for pair in pairs], dtype=float)
    scale = np.linalg.norm(np.subtract(*hacksaw(backdrop=corners).drawn()["A"][[0, 180]])) / (2 * R2)
    np.testing.assert_allclose(np.diff(drawn, axis=0), np.diff(corners, axis=0) * scale * (1, -1), atol=0.05)
    width, height = map(float, re.search(r'viewBox="0 0 (\S+) (\S+)"', html).groups())
    assert (drawn >= 40).all() and (drawn <= (width - 40, height - 40)).all()


def test_a_turn_of_three_joints_and_six_values_is_smaller_than_60_kb():
    assert len(hacksaw(arrows=[])._repr_html_().encode()) < 60_000


def test_a_number_that_rounds_to_zero_has_no_sign_and_a_negative_one_has_a_minus():
    assert Quantity("x", [-0.001, -1.26], "m", 1).texts() == ["0.0\N{NO-BREAK SPACE}m", "−1.3\N{NO-BREAK SPACE}m"]


def test_no_text_can_leave_its_place():
    html = hacksaw(alt='"</svg><b>', values=[Quantity("</script><b>", np.zeros(360))])._repr_html_()
    assert "<b>" not in html
    assert html.count("</script>") == 1


# What the reader does with it

FRAME = ".mechanism input[type=range]"


@pytest.fixture
def show(chromium, tmp_path):
    """Opens a page with some figures; afterwards there must have been no error."""
    trouble, contexts = [], []

    def page(*figures, theme="light", space=0, **options):
        body = f'<div style="height: {space}px"></div>'.join(["", *(figure._repr_html_() for figure in figures), ""])
        path = tmp_path / "page.html"
        path.write_text(
            f'<!doctype html><html lang="en" data-theme="{theme}"><meta charset="utf8"><title>Page</title>'
            '<meta name="viewport" content="width=device-width"><style>'
            f"body {{ --pst-color-background: {THEMES[theme]}; background: {THEMES[theme]} }}"
            "html[data-theme=dark] body { --pst-color-text-base: #ced6dd; --pst-color-text-muted: #9ca4af }</style>"
            f'<link rel="stylesheet" href="{(STATIC / "mechanism.css").as_uri()}">'
            f'<script src="{(STATIC / "mechanism.js").as_uri()}"></script><body>{body}',
            encoding="utf8",
        )
        contexts.append(chromium.new_context(**{"viewport": {"width": 800, "height": 600}, **options}))
        tab = contexts[-1].new_page()
        tab.on("console", lambda message: trouble.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: trouble.append(str(error)))
        tab.goto(path.as_uri())
        return tab

    yield page
    for context in contexts:
        context.close()
    assert trouble == []


def frame(tab, figure=0):
    return int(tab.locator(FRAME).nth(figure).input_value())


def place(tab, points, figure=0):
    """From SVG units to the screen."""
    box = tab.locator("svg").nth(figure).bounding_box()
    scale = box["width"] / float(tab.locator("svg").nth(figure).get_attribute("viewBox").split()[2])
    return np.array([box["x"], box["y"]]) + scale * np.asarray(points)


def drag(tab, points):
    """Press at the first point, move through all of them, let go; the frame that is shown after each move."""
    tab.evaluate(
        """() => {
            const range = document.querySelector("input[type=range]");
            window.shown = [];
            document.querySelector("svg").addEventListener("pointermove", () => window.shown.push(range.valueAsNumber));
        }"""
    )
    tab.mouse.move(*points[0])
    tab.mouse.down()
    tab.evaluate("shown.length = 0")
    for point in points:
        tab.mouse.move(*point)
    tab.mouse.up()
    return tab.evaluate("shown")


EVERY_FRAME = """() => {
    const range = document.querySelector("input[type=range]");
    const middle = (element) => {
        const { left, right, top, bottom } = element.getBoundingClientRect();
        return [(left + right) / 2, (top + bottom) / 2];
    };
    const onScreen = (line, point) => point.matrixTransform(line.getScreenCTM());
    const ends = (line) => [...line.points].map((point) => onScreen(line, point)).map(({ x, y }) => [x, y]);
    return [...Array(Number(range.max) + 1).keys()].map((k) => {
        range.value = k;
        range.dispatchEvent(new Event("input"));
        return {
            joints: [..."OAB"].map((name) => middle(document.querySelector(`.joint[data-joint=${name}] circle`))),
            block: middle(document.querySelector(".block")),
            bars: [...document.querySelectorAll("[data-chain]")].map(ends),
            values: [...document.querySelectorAll("dd")].map((value) => value.textContent),
            says: range.getAttribute("aria-valuetext"),
            layout: JSON.stringify([...document.querySelectorAll("dl, dt, dd, .controls > *")].map((element) => {
                const { left, right, top, bottom } = element.getBoundingClientRect();
                return [left, right, top, bottom];
            })),
        };
    });
}"""


@pytest.mark.parametrize("width", [800, 360])
def test_every_frame_on_the_screen_is_the_frame_that_was_computed(show, width):
    saw = hacksaw()
    drawn = saw.drawn()
    tab = show(saw, viewport={"width": width, "height": 600})
    frames = tab.evaluate(EVERY_FRAME)
    assert len(frames) == 360

    joints = np.array([each["joints"] for each in frames])
    computed = np.stack([np.broadcast_to(drawn[name], (360, 2)) for name in "OAB"], axis=1)
    np.testing.assert_allclose(joints, place(tab, computed), atol=0.5)
    np.testing.assert_allclose([each["block"] for each in frames], joints[:, 2], atol=0.5)

    bars = np.array([each["bars"] for each in frames])
    np.testing.assert_allclose(bars, np.stack((joints[:, :2], joints[:, 1:]), axis=1), atol=0.5)
    lengths = np.linalg.norm(bars[:, :, 1] - bars[:, :, 0], axis=-1)
    assert (np.ptp(lengths, axis=0) < 1).all()  # rigid
    np.testing.assert_allclose(lengths[:, 1] / lengths[:, 0], R3 / R2, rtol=2e-3)

    assert [each["values"] for each in frames] == list(map(list, zip(*data(saw)["values"], strict=True)))
    assert [each["says"] for each in frames] == [f"θ₂ = {k}°" for k in range(360)]
    assert len({each["layout"] for each in frames}) == 1  # no number moves another


def test_the_crank_pin_follows_the_pointer_to_the_nearest_frame(show):
    saw = hacksaw()
    tab = show(saw)
    pins = place(tab, saw.drawn()["A"])
    centre = place(tab, saw.drawn()["O"][0])
    tab.mouse.move(*pins[40])
    tab.mouse.down()
    for k, reach in np.random.default_rng(1).uniform((0, 0.4), (360, 2), (40, 2)):
        k = int(k)
        tab.mouse.move(*(centre + reach * (pins[k] - centre)))
        assert frame(tab) == k
    tab.mouse.up()
    tab.mouse.move(*pins[0])
    assert frame(tab) == k  # let go


def test_a_grip_beside_the_joint_does_not_move_it(show):
    saw = hacksaw()
    tab = show(saw)
    tab.mouse.move(*np.add(place(tab, saw.drawn()["A"][40]), 9))
    tab.mouse.down()
    tab.mouse.move(*np.add(place(tab, saw.drawn()["A"][80]), 9))
    assert frame(tab) == 80


@pytest.mark.parametrize(("frames", "sense"), [(360, 1), (360, -1), (60, 1)])
def test_the_slider_carries_the_crank_through_its_dead_points(show, frames, sense):
    saw = hacksaw(frames, start=frames // 6)
    tab = show(saw)
    path = place(tab, saw.drawn()["B"])
    left, right = path[:, 0].min() - 5, path[:, 0].max() + 5
    turns = pairwise((path[frames // 6, 0], *(left, right)[::sense], *(left, right)[::sense]))
    xs = np.concatenate([np.linspace(start, end, int(abs(end - start) / 5)) for start, end in turns])
    seen = drag(tab, [(x, path[frames // 6, 1]) for x in xs])
    steps = (np.diff(seen) + frames / 2) % frames - frames / 2
    assert (np.sign(steps[steps != 0]) == sense).all()  # it never turns back, and never jumps to the other branch
    assert np.abs(steps).max() <= frames / 12  # 5 pixels at a dead point are 16 degrees
    assert abs(steps.sum()) > 1.5 * frames  # twice there and back


def test_a_slider_that_turns_round_before_its_dead_point_turns_the_crank_back(show):
    saw = hacksaw()
    tab = show(saw)
    path = place(tab, saw.drawn()["B"])
    there_and_back = [*range(40, 120, 4), *range(120, 60, -4)]
    np.testing.assert_allclose(drag(tab, path[there_and_back]), there_and_back, atol=1)


def test_a_motion_with_two_ends_stops_at_them(show):
    moving = cylinder()
    tab = show(moving)
    path = place(tab, moving.drawn()["J"])
    tab.mouse.move(*path[0])
    tab.mouse.down()
    for target, expected in ((path[50], 50), (path[-1] - (0, 60), 79), (path[0] + (0, 60), 0)):
        tab.mouse.move(*target)
        assert frame(tab) == expected
    assert tab.locator(".handle").count() == 1  # D is fixed, and the ends of barrel and rod have no name


def test_the_keyboard_reaches_every_frame(show):
    tab = show(hacksaw())
    tab.keyboard.press("Tab")
    tab.keyboard.press("Tab")
    slider = tab.get_by_role("slider", name=f"{WORDS['position']}, θ₂")
    for key, expected in (("ArrowRight", 41), ("ArrowLeft", 40), ("End", 359), ("Home", 0)):
        tab.keyboard.press(key)
        assert frame(tab) == expected
        assert slider.get_attribute("aria-valuetext") == f"θ₂ = {expected}°"
    tab.keyboard.press("PageUp")
    assert frame(tab) > 10
    assert slider.evaluate("(element) => getComputedStyle(element).outlineStyle") == "solid"


def test_play_takes_the_time_it_should_and_pause_stops(show):
    tab = show(hacksaw(seconds=2.0, start=0))
    shown, elapsed = tab.evaluate(
        """() => new Promise((done) => {
            const begin = performance.now();
            document.querySelector("button").click();
            const look = () => {
                const elapsed = performance.now() - begin;
                if (elapsed < 500) requestAnimationFrame(look);
                else done([document.querySelector("input[type=range]").valueAsNumber, elapsed]);
            };
            look();
        })"""
    )
    assert 0.5 < shown / (180e-3 * elapsed) < 1.05  # 360 frames in 2 s; a busy computer may be late, and never early
    tab.get_by_role("button", name=WORDS["pause"]).click()
    stopped = frame(tab)
    tab.wait_for_timeout(150)
    assert frame(tab) == stopped
    assert tab.get_by_role("button", name=WORDS["play"]).count() == 1


def test_a_motion_with_two_ends_is_played_there_and_back(show):
    tab = show(replace(cylinder(), seconds=0.2))
    tab.get_by_role("button").click()
    seen = tab.evaluate(
        """() => new Promise((done) => {
            const range = document.querySelector("input[type=range]"), seen = [], begin = performance.now();
            const look = (now) => {
                seen.push(range.valueAsNumber);
                if (now - begin < 600) requestAnimationFrame(look); else done(seen);
            };
            look(begin);
        })"""
    )
    steps = np.diff(seen)
    assert steps.max() > 0 > steps.min()
    assert np.abs(steps).max() < 40  # no jump from one end to the other


def test_autoplay_starts_when_seen_rests_out_of_sight_and_stops_at_a_touch(show):
    saw = hacksaw(autoplay=True, start=0)
    tab = show(saw, space=1500)
    tab.wait_for_timeout(150)
    assert frame(tab) == 0
    tab.evaluate("scrollTo(0, 1400)")
    tab.wait_for_timeout(300)
    assert frame(tab) > 0
    tab.evaluate("scrollTo(0, 0)")
    tab.wait_for_timeout(100)
    rests = frame(tab)
    tab.wait_for_timeout(150)
    assert frame(tab) == rests
    tab.evaluate("scrollTo(0, 1400)")
    tab.locator(FRAME).press("Home")
    tab.wait_for_timeout(150)
    assert frame(tab) == 0
    assert tab.get_by_role("button", name=WORDS["play"]).count() == 1


def test_with_reduced_motion_nothing_starts_by_itself_and_play_goes_step_by_step(show):
    tab = show(hacksaw(autoplay=True, seconds=1.0, start=0), reduced_motion="reduce")
    tab.wait_for_timeout(250)
    assert frame(tab) == 0
    tab.get_by_role("button", name=WORDS["play"]).click()
    tab.wait_for_timeout(450)
    assert 1 <= frame(tab) <= 20  # 4, and 160 for other readers


def test_a_finger_drags_a_joint_and_scrolls_beside_it(show):
    saw = hacksaw()
    phone = {"viewport": {"width": 360, "height": 600}, "has_touch": True, "is_mobile": True}
    tab = show(saw, space=900, **phone)
    tab.evaluate("scrollTo(0, 700)")
    finger = tab.context.new_cdp_session(tab)

    def swipe(*points):
        for kind, point in (("touchStart", points[0]), *(("touchMove", point) for point in points)):
            finger.send(
                "Input.dispatchTouchEvent", {"type": kind, "touchPoints": [dict(zip("xy", point, strict=True))]}
            )
        finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        tab.wait_for_timeout(50)

    pins = place(tab, saw.drawn()["A"])
    swipe(*pins[40:131:6])
    assert frame(tab) == pytest.approx(130, abs=1)
    assert tab.evaluate("scrollY") == 700

    empty = place(tab, (30, 30))
    swipe(*(empty - (0, y) for y in range(0, 100, 10)))
    assert tab.evaluate("scrollY") > 700
    assert frame(tab) == pytest.approx(130, abs=1)


def test_a_finger_has_room_and_the_phone_has_no_sideways_scroll(show):
    tab = show(hacksaw(), cylinder(), viewport={"width": 360, "height": 600}, has_touch=True, is_mobile=True)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 360
    for selector, size in ((".handle", 44), ("button, input[type=checkbox], input[type=range]", 24)):
        for element in tab.locator(selector).all():
            box = element.bounding_box()
            assert min(box["width"], box["height"]) >= size - 0.01


def test_arrows_are_shown_on_demand(show):
    saw = hacksaw()
    tab = show(saw)
    arrow = tab.locator(".arrow")
    assert not arrow.get_attribute("d")
    tab.get_by_label("velocity at 1 rad/s, the longest 0.075\N{NO-BREAK SPACE}m/s").check()
    x, y = saw.drawn()["A"][40]
    u, v = data(saw)["arrows"][0]["vectors"]["A"][40]
    assert arrow.get_attribute("d").startswith(f"M{x:g} {y:g}l{u:g} {v:g}m")
    assert frame(tab) == 40


def test_two_figures_do_not_disturb_each_other(show):
    saw = hacksaw()
    tab = show(saw, saw, viewport={"width": 800, "height": 1200})
    tab.mouse.move(*place(tab, saw.drawn()["A"][40], 1))
    tab.mouse.down()
    tab.mouse.move(*place(tab, saw.drawn()["A"][80], 1))
    assert [frame(tab, 0), frame(tab, 1)] == [40, 80]


def test_without_script_the_still_is_there_and_no_dead_control(show):
    tab = show(hacksaw(), java_script_enabled=False)
    assert tab.get_by_role("img", name="A crank turns about O").is_visible()
    assert tab.locator("dd").first.inner_text() == "40°"
    assert tab.locator("button, input, .handle").count() == 0


def test_paper_has_the_picture_and_no_controls(show):
    tab = show(hacksaw())
    assert tab.locator(".controls").is_visible()
    tab.emulate_media(media="print")
    assert not tab.locator(".controls").is_visible()
    assert tab.locator("svg").is_visible()


def luminance(colour):
    c = np.array([float(part) for part in re.findall(r"[\d.]+", colour)[:3]]) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722)


@pytest.mark.parametrize("theme", THEMES)
def test_lines_stand_out_from_the_page_three_to_one_and_letters_more(show, theme):
    bodies = {f"body {k}": "OA" for k in range(4)} | {"plate": "OABO"}
    tab = show(hacksaw(bodies=bodies, traces="B", cloud=[(0, 0)], backdrop=[(0, 0), (0.1, 0), (0, 0.1)]), theme=theme)
    style = "(elements, name) => elements.map((element) => getComputedStyle(element)[name])"

    def colours(name, selector):
        found = tab.locator(selector).evaluate_all(style, name)
        assert found and all(colour.startswith("rgb(") for colour in found)
        return set(found)

    drawn = colours("stroke", "[data-chain], .ground, .guide, .block, .trace, .cloud, .backdrop, .joint circle, .arrow")
    read = colours("fill", "svg text") | colours("color", "dt, dd, button, label")
    page = luminance(tab.locator("body").evaluate("(element) => getComputedStyle(element).backgroundColor"))
    for least, found in ((3, drawn | colours("borderTopColor", "button")), (4.5, read)):
        for colour in found:
            dark, light = sorted((page, luminance(colour)))
            assert (light + 0.05) / (dark + 0.05) >= least, colour
