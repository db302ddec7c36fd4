"""Scenes of rigid links whose joints have laws."""

import fenics_mech as fm

G = 9.81


def block(law: dict, mass: float = 1.0, spring: float | None = 100.0, **changes) -> fm.Scene:
    """Give a block that slides along X on the ground, in general on a spring, with a law in its guide."""
    springs = {} if spring is None else {"s": fm.LineSpring(between=("ground.W", "block.B"), stiffness=spring)}
    scene = fm.Scene(
        name="block",
        ground=fm.Ground(points={"O": (0, 0), "W": (-1, 0)}),
        links={"block": fm.Link(points={"B": (0, 0)}, rigid=fm.RigidBody(mass=mass))},
        joints={"G": fm.Prismatic(connect=("ground.O", "block.B"))},
        gravity=(0, -G),
        springs=springs,
        joint_laws={"law": {"joint": "G", **law}},
        analysis=fm.Analysis(method="transient", duration=1.0, sub_intervals=200, time_tolerance=1e-6),
    )
    return scene.changed(changes)


def bar(law: dict, **changes) -> fm.Scene:
    """Give a bar of 1 m and 1 kg that hangs from a pin with a law, and starts along X."""
    scene = fm.Scene(
        name="bar",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "bar": fm.Link(
                points={"O": (0, 0)}, rigid=fm.RigidBody(mass=1.0, inertia=1 / 12, centre=(0.5, 0)), angle="-90 deg"
            )
        },
        joints={"O": fm.Revolute(connect=("ground.O", "bar.O"))},
        gravity=(0, -G),
        joint_laws={"law": {"joint": "O", **law}},
        analysis=fm.Analysis(method="transient", duration=1.0, sub_intervals=200, time_tolerance=1e-6),
    )
    return scene.changed(changes)
