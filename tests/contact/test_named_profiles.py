import numpy as np
import pytest

from wheelset_track_sim.contact.named_profiles import load_profile, plain_profile, read_profile, with_points
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import load_scenario, scenario_from


def table(unit_y="mm", unit_z="mm", scale=1.0):
    rows = "".join(f"{y * scale:g},{-1e-3 * y * y * scale:g}\n" for y in range(-30, 31))
    return f"# measured by hand\n\n y_{unit_y}, z_{unit_z}\n{rows}"


def test_files_are_read_in_their_units(tmp_path):
    (tmp_path / "a.csv").write_text(table())
    (tmp_path / "b.csv").write_text(table("m", "m", 1e-3))
    (tmp_path / "c.yaml").write_text(
        f"y: {[1e-3 * y for y in range(-30, 31)]}\nz: {[-1e-6 * y * y for y in range(-30, 31)]}\n"
    )
    found = [load_profile("wheel", tmp_path / name) for name in ("a.csv", "b.csv", "c.yaml")]
    for points in found:
        np.testing.assert_allclose(points.y, np.arange(-30, 31) * 1e-3, atol=1e-11)
        np.testing.assert_allclose(points.z, -1e-6 * np.arange(-30, 31) ** 2, atol=1e-11)
    assert read_profile("rail", plain_profile("wheel", found[0]), "it") == found[0]
    assert with_points("wheel", str(tmp_path / "a.csv"), "it") == plain_profile("wheel", found[0])
    assert with_points("wheel", "s1002", "it") == "s1002"


UPRIGHT = ["profiles.inclination=0.025", "profiles.gauge=1.435"]


def test_a_scenario_takes_in_its_files(tmp_path):
    (tmp_path / "tread.csv").write_text(table())
    scenario = load_scenario(
        "undamaged", [f"profiles.wheel_1={tmp_path / 'tread.csv'}", "profiles.wheel_2=s1002_hollow", *UPRIGHT]
    )
    assert scenario.profiles.wheel_1.z[0] == -9e-4
    assert scenario.to_mapping()["profiles"]["wheel_2"] == "s1002_hollow"
    assert scenario_from(parse(scenario.to_yaml(), "its own text")) == scenario


def test_unknown_names_and_files_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"profile of a wheel: did you mean s1002\?.*cylinder, cone_1_40"):
        read_profile("wheel", "s1003", "it")
    with pytest.raises(InputError, match="known are head_60e1, head_60e1_points"):
        read_profile("rail", "s1002", "it")
    with pytest.raises(InputError, match=r"none\.csv does not exist: give a file with y and z, or one of head_60e1"):
        load_profile("rail", tmp_path / "none.csv", "it")
    with pytest.raises(InputError, match="is no file"):
        load_profile("rail", tmp_path, "it")
    with pytest.raises(InputError, match=r"profile: 's1003' is not a known profile of a wheel"):
        load_profile("wheel", "s1003")
    with pytest.raises(InputError, match=r"points of a wheel\.z is missing"):
        read_profile("wheel", {"y": [0.0]}, "it")


def test_plain_data_open_no_file(tmp_path):
    """Those of a bag, a topic or a service."""
    (tmp_path / "a.csv").write_text(table())
    mapping = load_scenario("undamaged").to_mapping()
    for given in (str(tmp_path / "a.csv"), {"file": str(tmp_path / "a.csv")}):
        with pytest.raises(InputError, match=r"profiles\.wheel_1: .*(is not a known profile|file is not a known key)"):
            scenario_from(mapping | {"profiles": {"wheel_1": given}})


def test_shipped_points_say_where_they_are_from():
    for side in ("wheel", "rail"):
        for name in shipped.names(f"{side}_profiles", ".csv"):
            about = [
                line
                for line in shipped.file(f"{side}_profiles", f"{name}.csv").read_text().splitlines()
                if line[0] == "#"
            ]
            assert any(word in " ".join(about) for word in ("EN 13715", "EN 13674-1", "Synthetic"))
            assert len(read_profile(side, name, "it").y) > 200


def test_s1002_has_the_dimensions_of_the_standard():
    points = read_profile("wheel", "s1002", "it")
    y, z = np.array(points.y), np.array(points.z)
    assert z[y == 0.0] == 0.0
    assert z.max() == pytest.approx(0.028, abs=1e-7)  # flange height
    # Flange thickness: 10 mm above the rolling circle, to the back face 70 mm from it.
    face = (y > -0.05) & (y < -0.03)
    assert 0.070 + np.interp(-0.010, -z[face], y[face]) == pytest.approx(0.0325, abs=2e-4)
    outside = y > 0.033
    assert np.diff(z[outside]) / np.diff(y[outside]) == pytest.approx(-1 / 15, abs=1e-3)
    slope = np.interp(0.0, y[:-1], np.diff(z) / np.diff(y))
    assert slope == pytest.approx(-1 / 30, abs=1e-3)


def test_hollow_wheel_has_lost_material_nowhere_but_on_the_tread():
    new, worn = (read_profile("wheel", name, "it") for name in ("s1002", "s1002_hollow"))
    lost = np.array(new.z) - np.array(worn.z)
    y = np.array(new.y)
    assert 0.5e-3 < lost.max() < 1.6e-3
    assert abs(y[lost.argmax()]) < 0.03
    assert np.abs(lost[(y < -0.05) | (y > 0.05)]).max() < 1e-5
