"""What acts in a freedom is called its effort, and not the torque of a drive that is not there."""

import pytest

import fenics_mech as fm
from fenics_mech.views.details import effort_of


@pytest.mark.parametrize(("driven", "names"), [(False, ("effort", "Effort")), (True, ("input torque", "Drive torque"))])
def test_effort_in_a_freedom_is_not_named_after_a_drive(driven, names):
    rotor = fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(mass=1.0, inertia=0.1, centre=(0.2, 0)))
    motion = (
        {"drive": fm.Drive(joint="O", law=fm.Harmonics(sine=(1.0,)), period=1.0)}
        if driven
        else {"freedoms": {"O": fm.Freedom(effort=2.0)}}
    )
    scene = fm.Scene(
        name="rotor",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"rotor": rotor},
        joints={"O": fm.Revolute(connect=("ground.O", "rotor.O"))},
        analysis=fm.Analysis(method="quasi-static", sub_intervals=20)
        if driven
        else fm.Analysis(method="transient", duration=0.1, sub_intervals=4),
        **motion,
    )
    result = fm.analyse(scene)
    assert (effort_of(result)[0], fm.plot_drive(result).get_title(loc="left")) == names
