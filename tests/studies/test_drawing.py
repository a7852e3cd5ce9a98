"""Files of figures and tables."""

import pytest
from matplotlib.figure import Figure

from wheelset_track_sim.studies.drawing import parquet, save, table


@pytest.mark.parametrize("name", ["../x", "/x", "x"])
def test_a_name_in_a_study_leads_out_of_no_folder(tmp_path, name):
    out = tmp_path / "out"
    assert save(out, name, Figure((1, 1))) == [out / "x.png", out / "x.svg", out / "x.pdf"]
    assert table(out, name, {"a": [1.0]}) == out / "x.csv"
    assert {path.name for path in tmp_path.iterdir()} == {"out"}


def test_parquet_has_all_digits_and_text(tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    columns = {"speed (m/s)": [0.1 + 0.2, 1 / 3], "dynamics": ["causal", "paper"]}
    found = pandas.read_parquet(parquet(tmp_path, "runs", columns))
    assert found.to_dict("list") == columns
