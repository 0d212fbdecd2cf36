# SPDX-License-Identifier: Apache-2.0
"""The report's claims, on its sections' own JSON from small grids, and the page made of it."""

from __future__ import annotations

import ast
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from wavehaptics.laws import closed_forms
from wavehaptics.parts import foc_designs
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies import stability
from wavehaptics.studies.report import (
    blocks,
    broken_inputs,
    build,
    converters,
    energies,
    field_oriented,
    hard_cases,
    in_space,
    integrators,
    ladder,
    latency,
    old_way,
    page,
    paper,
    parts,
    rates,
    spectrum,
    widths,
)
from wavehaptics.trace import pictures


def collect(section: Any, keep) -> dict[str, Any]:
    """The JSON of a section whose quick tasks are those that ``keep`` takes."""
    tasks = [task for task in section.tasks(True) if keep(task)]
    results = [task.function(**task.arguments) for task in tasks]
    return json.loads(json.dumps(section.gather(tasks, results), allow_nan=False))


def settings_of(task: Any) -> str:
    return " ".join(task.arguments.get("settings", ()))


@pytest.mark.parametrize("case", hard_cases.CASES)
def test_hard_case_is_as_expected(case):
    outcome = hard_cases.check(case)
    assert outcome["ok"], (outcome["found"], outcome["numbers"])
    assert outcome["numbers"]


def names_of_tests(file: str) -> set[str]:
    """Names of the functions of a file of the repository."""
    nodes = ast.walk(ast.parse((ROOT / file).read_text(encoding="utf-8")))
    return {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}


@pytest.mark.parametrize(
    ("file", "test"),
    [
        *((file, test) for _, _, file, test in hard_cases.BY_TEST),
        *((f"sim/tests/{file}", test) for _, file, test in paper.EQUATIONS),
    ],
)
def test_the_tests_that_the_report_names_are_there(file, test):
    assert test in names_of_tests(file)


def test_the_report_reads_no_tests(monkeypatch):
    """Its package stands by itself."""

    def read(path, *arguments, **options):
        raise AssertionError(f"{path} is read")

    monkeypatch.setattr(Path, "read_text", read)
    monkeypatch.setattr(Path, "read_bytes", read)
    tested = hard_cases.gather([], [])["tested"]
    assert [row["test"] for row in tested] == [row[-1] for row in hard_cases.BY_TEST]
    assert any("twice what (14) prints" in statement for statement, _, _ in paper.EQUATIONS)


def test_glitches_that_are_not_filtered_would_be_felt():
    assert broken_inputs.glitches(broken_inputs.GLITCH_CLOCKS + 1) > 1e-5


def test_the_way_out_differs_only_after_saturation():
    within = paper.way_in_and_out(0.024, 2.1)
    limited = paper.way_in_and_out(0.036, 2.1)
    far = paper.way_in_and_out(0.036, 12.0)
    assert within["saturated"] == far["saturated"] == 0
    assert within["work_ratio"] == pytest.approx(1, abs=2e-3)
    assert far["work_ratio"] == pytest.approx(1, abs=2e-3)
    assert limited["saturated"] > 0.1
    assert limited["work_ratio"] < 0.5
    assert limited["slope_out"] == pytest.approx(limited["slope_in"], rel=2e-3)
    assert limited["zero_rad"] > 5e-3 > 1e-3 > far["zero_rad"]


def test_rates(tmp_path):
    data = collect(rates, lambda t: t.arguments["controller"] == "golden"
                   and re.search("tick_hz=(10000|100000|1000000).0 ", settings_of(t)))  # fmt: skip
    slow, middle, fast = data["points"]
    assert (slow["tick_hz"], fast["tick_hz"]) == pytest.approx((1e4, 1e6))
    assert fast["torque_error"] < middle["torque_error"] < slow["torque_error"]
    assert fast["torque_error"] < 5e-4
    assert max(p["prediction_error"] for p in data["points"]) < 0.02
    assert slow["stiffness_error"] > 0.1 > 1e-3 > fast["stiffness_error"]
    assert rates.show(data, tmp_path)


def test_a_disc_is_stiff_and_quiet_under_a_light_hand(tmp_path):
    data = collect(in_space, lambda t: True)
    wave, soft, stiff = data["walls"]
    assert wave["lost_s"] == soft["lost_s"] == 0.0
    assert wave["error"] < 0.05
    assert wave["stiffness"] > 10 * soft["stiffness"]
    assert wave["deepest_m"] < 0.6e-3 < soft["depth_m"]
    assert stiff["lost_s"] > 0.1  # it chatters
    assert stiff["deepest_m"] > 2e-3
    assert in_space.show(data, tmp_path)


def test_latency_softens_and_does_no_more(tmp_path):
    data = collect(latency, lambda t: t.arguments["extra_ticks"] in (1, 100, 1000))
    points = data["points"]
    assert all(p["error"] < 1e-2 and p["stable"] for p in points)
    assert all(p["energy_out_max_j"] <= 0 for p in points)
    assert points[0]["stiffness"] > points[1]["stiffness"] > points[2]["stiffness"]
    assert latency.show(data, tmp_path)


@pytest.mark.long
def test_longer_words_are_better(tmp_path):
    data = collect(widths, lambda t: (t.arguments["name"], t.arguments["bits"]) in
                   {("DATA_W", 16), ("DATA_W", 24), ("STATE_GUARD", 1)})  # fmt: skip
    short, longer, unguarded = (p["torque_error"] for p in data["points"])
    assert short > 0.05
    assert longer < 0.01 > unguarded
    assert widths.show(data, tmp_path)


@pytest.mark.parametrize("name", widths.WIDTHS)
def test_the_shortest_words_run(name):
    """Quickly: those of the whole report, not only of its quick form."""
    error = widths.at_width(name, min(widths.WIDTHS[name]), widths.SCENE, ["scene.duration_s=0.02"])
    assert set(error) == {"torque_error", "stiffness", "free_space_torque_rms"}


def test_more_bits_are_better(tmp_path):
    data = collect(converters, lambda t: re.search(r"adc.bits=(8|16)$", settings_of(t)))
    coarse, fine = data["adc"]
    assert fine["torque_error"] < 0.01 < 0.02 < coarse["torque_error"]
    assert converters.show(data, tmp_path)


def test_the_exact_table_is_exact(tmp_path):
    data = collect(integrators, lambda t: t.arguments["method"] not in integrators.SOLVERS)
    error = {(p["method"], round(p["step_s"] * 1e7)): p["error"] for p in data["points"]}
    assert error.pop(("exact", 100)) < 1e-12
    assert min(value for (method, _), value in error.items() if method == "Euler") > 1e-5
    assert error["RK4", 100] < 1e-6 < error["Euler", 5]
    assert error["Euler", 100] / error["Euler", 5] == pytest.approx(20, rel=0.2)
    cost = {(p["method"], round(p["step_s"] * 1e7)): p["cost_s_per_s"] for p in data["points"]}
    assert cost["exact", 100] < 0.5 * cost["RK4", 5]
    assert integrators.show(data, tmp_path)


def test_pwm_steps_cost_little(tmp_path):
    """Error feedback: a quarter of the steps at a faster carrier leaves the torque within 1 %."""
    data = collect(converters, lambda t: t.arguments["controller"] == "pins"
                   and "clock_hz=48000000.0" in settings_of(t))  # fmt: skip
    pwm = sorted(data["pwm"], key=lambda p: p["steps"])
    assert pwm[-1]["steps"] == 4 * pwm[0]["steps"]
    assert max(p["torque_error"] for p in pwm) < 0.01
    ripples = [p["ripple_a"] for p in pwm]
    assert ripples == sorted(ripples), "a slower carrier has more ripple"
    assert converters.show(data, tmp_path)


def test_cheapest_model_is_cheaper_and_good_enough():
    models = parts.cheapest("impact", ["scene.duration_s=0.02"])
    data = parts.gather([None, type("T", (), {"arguments": {"scene": "impact"}})], [[], models])
    scene = data["scenes"]["impact"]
    best = next(m for m in models if m["model"] == scene["recommended"])
    assert best["model"] != "pins"
    assert best["error"] < parts.NEEDED
    assert best["cost_s_per_s"] < 0.5 * models[0]["cost_s_per_s"]


def test_parts_that_a_scene_needs_and_parts_that_it_does_not(tmp_path):
    """Part by part on the paper's taps, shorter than in the report, but with a contact."""
    models = parts.on_and_off("paper_taps", [*parts.WHOLE, "scene.duration_s=0.2"])
    error = {m["model"]: m["error"] for m in models}
    assert error["golden, every part"] < parts.NEEDED
    alone = {part: error[f"golden without {part}"] for part in parts.PARTS}
    assert alone["hand"] > 3 * max(value for part, value in alone.items() if part != "hand")
    assert alone["adc"] > parts.NEEDED
    assert alone["friction"] > 2 * error["golden, every part"]
    # The wall's edge is one of the encoder's, and the voltage stays below its limit.
    assert alone["encoder"] == alone["drive"] == error["golden, every part"]
    scenes = {"paper_taps": {"models": models, "recommended": "golden, every part"}}
    assert parts.show({"whole": models, "scenes": scenes}, tmp_path)


def test_ladder(tmp_path):
    data = collect(ladder, lambda t: True)
    rungs = {p["controller"]: p for p in data["points"]}
    assert list(rungs) == list(ladder.WAVE_RUNGS)
    assert rungs["golden"]["torque_error"] == rungs["core"]["torque_error"] < 5e-4
    assert rungs["core"]["torque_error"] < rungs["pins"]["torque_error"] < 5e-3
    assert max(p["stiffness_error"] for p in data["points"]) < 0.01
    assert all(p["simulated_s_per_s"] > 0 for p in data["points"])
    assert [name for name, p in rungs.items() if p["cycles_per_s"]] == ["core", "pins"]
    assert ladder.show(data, tmp_path)


def test_the_papers_experiment(tmp_path):
    """K of both, and that the paper's prototype lies above them and (14) as printed below."""
    ways = [way for way in paper.tasks(True) if way.function is paper.way_in_and_out]
    runs = [paper.experiment(controller, 0.3) for controller in ("analog", "pins")]
    fake = dict.fromkeys(
        ("saturated", "work_ratio", "slope_in", "slope_out", "zero_rad"), 0.5
    ) | {"x": [0.0, 1e-3], "push": [0.0, 1e-3]}  # fmt: skip
    ways = [task.arguments | fake for task in ways]
    data = json.loads(json.dumps(paper.gather([], [*runs, *ways]), allow_nan=False))
    analog, pins = (data[name]["metrics"] for name in ("analog", "pins"))
    assert pins["stiffness"] == pytest.approx(pins["stiffness_predicted"], rel=0.01)
    assert analog["stiffness"] == pytest.approx(analog["stiffness_predicted"], rel=2e-3)
    assert pins["torque_nrmse_vs_analog"] < 5e-3
    filter_k = closed_forms.filter_stiffness(23.4e-3, 2.18, 1e4)
    printed = 1 / (1 / pins["k_l"] + 2 / filter_k)
    assert printed < 0.8 * analog["stiffness"] < analog["stiffness"] < pictures.PAPER_MEASURED
    assert paper.show(data, tmp_path)


def test_the_usual_way():
    """The wave wall over the encoder's wall at a 1 kHz servo: the paper has 7500/1100 = 6.8."""
    encoder = old_way.limit("encoder", ["servo.rate_hz=1e3"])
    wave = old_way.limit("golden", ["controller.tick_hz=1e6", "controller.lambda=1e9"])
    assert wave["capped"]
    assert wave["stiffness"] * old_way.TIP == pytest.approx(7500, rel=0.01)
    assert wave["stiffness"] / encoder["stiffness"] >= 7500 / 1100
    firm = old_way.limit("encoder", ["servo.rate_hz=1e3", "hand.damping=1.53e-3"])
    assert firm["stiffness"] > encoder["stiffness"] * 5


def usual(curve: str, *settings: str) -> dict[str, Any]:
    """The point of a curve of the report whose task has these settings."""
    found = [task for name, task in old_way._grid(False) if name == curve
             and {*settings} <= {*task.arguments["settings"]}]  # fmt: skip
    assert len(found) == 1, (curve, settings)
    return old_way.limit(**found[0].arguments)


def test_the_encoders_wall_needs_the_hand_and_the_wave_wall_does_not():
    """A firm grip carries a 1 kHz servo beyond K_L, a light finger to a tenth of it and less."""
    light, firm = (f"hand.damping={old_way.HAND_DAMPING[n]}" for n in (0, -1))
    k_l = closed_forms.k_l(43.8e-3, 0.83e-3)
    assert usual("hand", light)["stiffness"] < 0.1 * k_l
    assert usual("hand", firm)["stiffness"] > k_l
    for hand in (light, firm):
        wave = usual("hand wave", hand)
        assert wave["capped"]
        assert wave["stiffness"] > 0.98 * k_l


def test_delay_softens_both_loops():
    """To a fifth and less in a millisecond; the wave wall does not swing even at ten of them."""
    torque = [usual("delay", f"servo.delay_s={d}")["stiffness"] for d in (0.0, 0.2e-3, 1e-3)]
    waves = [usual("delay wave", f"controller.extra_ticks={k}") for k in (0, 20, 100)]
    assert all(wave["capped"] for wave in waves)
    for first, second, third in (torque, [wave["stiffness"] for wave in waves]):
        assert first > second > third
        assert first > 4 * third
    late = ("controller.tick_hz=1e5", "controller.lambda=1e9", "controller.extra_ticks=1000")
    scene = old_way.load(old_way.SCENE, list(late))
    earlier, later = stability.swings(scene, "golden")
    assert max(earlier, later) < 0.2 * stability.cell_rad(scene)


def test_at_equal_rates_the_encoders_wall_can_be_the_stiffer():
    """With a fast amplifier at 100 kHz it goes beyond K_L, which is the wave wall's most."""
    k_l = closed_forms.k_l(43.8e-3, 0.83e-3)
    rate = "servo.rate_hz=100000.0"
    fast = usual("rate fast", rate)["stiffness"]
    assert fast > usual("rate", rate)["stiffness"] > k_l
    assert usual("wave rate 0", "controller.tick_hz=100000.0")["stiffness"] < k_l


def test_a_virtual_damper_helps_until_nothing_does():
    none, some, more = (
        usual("z 1000", f"servo.damping={b}")["stiffness"] for b in (0.0, 8e-5, old_way.DAMPERS[-1])
    )
    assert some > 1.2 * none
    assert more is None


def test_every_number_of_the_usual_way_has_its_curve():
    tasks = old_way.tasks(True)
    fake = [{"stiffness": 1.0 + n, "capped": False, "bound_sampling": 1.0,
             "bound_quantisation": 1.0} for n in range(len(tasks))]  # fmt: skip
    data = old_way.gather(tasks, fake)
    assert sum(len(points) for points in data["curves"].values()) == len(tasks)
    assert {row["motor"] for row in data["ratios"]} == set(old_way.MOTORS)


def beside_the_wave_wall(foc_hz: float, servo_hz: float) -> dict[str, Any]:
    """The point of the report for these rates."""
    (task,) = [
        task for _, point, task in field_oriented._grid(True)
        if point == {"foc_hz": foc_hz, "servo_hz": servo_hz}
    ]  # fmt: skip
    return task.function(**task.arguments)


def test_field_oriented_control_beside_the_wave_wall(tmp_path):
    """A 1 kHz servo is far softer, a fast one as stiff and stiffer, and all of them buzz."""
    (task,) = [task for _, point, task in field_oriented._grid(True) if "tick_hz" in point]
    wave = task.function(**task.arguments)
    motor = field_oriented.load(field_oriented.SCENE, []).motor
    k_l = closed_forms.k_l(motor.felt_k_t, motor.L_h)
    assert wave["capped"]
    assert 0.99 * k_l < wave["stiffness"] < k_l
    slow, quick = (beside_the_wave_wall(20e3, hz) for hz in (1e3, 20e3))
    assert 4 < wave["stiffness"] / slow["stiffness"] < 7
    assert 0.8 < wave["stiffness"] / quick["stiffness"] < 1.3
    fast = beside_the_wave_wall(1e6, 1e6)
    assert fast["stiffness"] > 4 * k_l
    assert fast["pressed_at"] == pytest.approx(wave["pressed_at"], rel=1e-6)
    assert wave["ripple"] < 20e-6
    for found in (slow, quick, fast):
        assert found["ripple"] > 10 * wave["ripple"]


def test_a_servo_needs_the_hand_and_its_bound_is_that_of_sampling():
    """2b/T of a sampled spring, without brushes as with them; the wave wall needs none."""
    limits = [
        field_oriented.limit(
            "encoder", [f"hand.damping={b}", "servo.rate_hz=1e3", "controller.tick_hz=1e5"], 6
        )["stiffness"]
        for b in (0.5e-4, 1.53e-4)
    ]  # fmt: skip
    for limit, b in zip(limits, (0.5e-4, 1.53e-4), strict=True):
        assert 0.5 < limit / (2 * b / 1e-3) < 1.5
    light = ["hand.damping=1.53e-6", "friction.viscous=1e-5", "controller.lambda=1e9"]
    assert field_oriented.limit("golden", light)["capped"]


def test_every_wall_of_a_brushless_motor_is_shown(tmp_path):
    tasks = field_oriented.tasks(True)
    fake = [{"stiffness": 1.0 + n, "capped": False, "pressed_at": 1.0, "ripple": 1e-5}
            for n in range(len(tasks))]  # fmt: skip
    data = json.loads(json.dumps(field_oriented.gather(tasks, fake)))
    assert sum(len(points) for points in data["curves"].values()) == len(tasks)
    assert field_oriented.show(data, tmp_path)
    assert (tmp_path / field_oriented.PICTURE).exists()
    _, rows = field_oriented.walls(data["curves"]["wall"])
    assert [row[2] for row in rows] == ["1", "2", "3", "4"]
    assert [row[3] for row in rows] == ["4", "2", "1.33", "1"]


def test_what_others_publish_has_a_source_and_no_guess():
    """Each by name in the page of sources; a dash for what they don't tell."""
    counted = {"table": "brushless", "option": "N = 2, AXES = 1", "lut": 12345, "dsp": 8}
    head, rows = field_oriented.beside([counted, counted | {"table": "blocks"}])
    assert [len(row) for row in rows] == [len(head)] * (1 + len(foc_designs.DESIGNS))
    assert rows[0][0] == "wh_ports: one brushless motor, with guard and anchors"
    assert rows[0][1:5] == ("1 MHz", "89 clocks, 1.17 µs at 76 MHz", "12,345", "8")
    for design, row in zip(foc_designs.DESIGNS, rows[1:], strict=True):
        assert f"``{design.name}``" in foc_designs.__doc__
        assert (row[3] == "–") is (design.lut is None)
    by_name = {design.name: design for design in foc_designs.DESIGNS}
    assert by_name["FPGA-FOC"].rate_hz == 18e3
    assert by_name["Vitis Motor Control Library"].lut == 9241


class _Links(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))


def test_the_page_needs_no_network(tmp_path):
    picture = tmp_path / "p.png"
    picture.write_bytes(b"\x89PNG not really")
    content = [
        blocks.Text("1 < 2 & 3"),
        blocks.Picture(picture, "a <caption>"),
        blocks.Table("t", ("name", "x"), [("one", 1.5), ("two", "–")]),
    ]
    text = page.render("Title", ["lead"], [("a", "A", content), ("b", "B", [])], "foot")
    parser = _Links()
    parser.feed(text)
    sources = [a.get("src") or a.get("href") or "" for _, a in parser.tags]
    sources = [source for source in sources if source]
    assert len(sources) == 3
    assert all(source.startswith(("data:image/png;base64,", "#")) for source in sources)
    assert "1 &lt; 2 &amp; 3" in text
    assert "http" not in text


def test_sections_have_their_parts():
    names = [build.name_of(section) for section in build.SECTIONS]
    assert len(set(names)) == len(names)
    assert set(build.TIMED) <= set(build.SECTIONS)
    for section in build.SECTIONS:
        assert section.TITLE
        quick, full = section.tasks(True), section.tasks(False)
        assert 0 < len(quick) <= len(full)


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0, "0"), (0.5, "0.5"), (-1.5e-7, "−1.5·10⁻⁷"), (123456, "1.2·10⁵")],
)
def test_numbers_as_text(value, text):
    assert blocks.number(value) == text


def test_the_mean_gives_no_energy_and_a_sample_does(tmp_path):
    data = collect(energies, lambda t: t.arguments["tick_hz"] in (500.0, 10e3))
    given = {(p["tick_hz"], p["point"]): p["energy_out_max_j"] for p in data["points"]}
    assert given[500.0, False] == given[10e3, False] == 0
    assert given[500.0, True] > 1e-6
    assert energies.show(data, tmp_path)


def test_error_feedback_clears_the_band(tmp_path):
    """Steps of 24 to 100 a period still give 12 bits and more below 5 kHz."""
    data = collect(spectrum, lambda t: True)
    rounded, first, second = (found["bits_in_band"] for found in data["orders"])
    assert rounded < 8
    assert first > 12
    assert second > first + 2
    assert spectrum.show(data, tmp_path)
