"""Types of messages that a bag names: only packages of interfaces are imported."""

import sys

import pytest

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(
    "kind", ["pranks/msg/Float64", "os.path/msg/Join", "../pranks/msg/A", "pranks", "this/msg/Zen", "numpy/msg/Array"]
)
def test_a_package_that_is_not_of_interfaces_is_not_imported(tmp_path, monkeypatch, kind):
    from wheelset_track_sim.ros.replay import message_type

    (tmp_path / "pranks" / "msg").mkdir(parents=True)
    (tmp_path / "pranks" / "__init__.py").write_text("raise SystemExit('it was imported')")
    (tmp_path / "pranks" / "msg" / "__init__.py").write_text("class Float64: ...")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ImportError, match="is not a message of an installed package"):
        message_type(kind)
    assert not {"pranks", "this"} & set(sys.modules)


def test_messages_of_installed_packages_are_found():
    from std_msgs.msg import Float64
    from wheelset_track_msgs.msg import ContactForces

    from wheelset_track_sim.ros.replay import message_type

    assert message_type("std_msgs/msg/Float64") is Float64
    assert message_type("wheelset_track_msgs/msg/ContactForces") is ContactForces
