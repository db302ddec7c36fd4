"""Vibration: the inertia of the elastic motion itself. Without it the response is quasi-static."""

from fenics_mech.effects.effect import Effect

EFFECT = Effect(
    name="vibration",
    meaning="inertia of the elastic motion; without it the response is quasi-static",
    source="(5.1)",
    size=lambda survey: survey.vibration,
    estimate="sum over modes and harmonics of the load of |H - 1|",
    stated=lambda scene: scene.analysis.method == "periodic",
)
