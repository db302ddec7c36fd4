"""Vibration: the inertia of the elastic motion itself. Without it the response is quasi-static."""

from fenics_mech.effects.effect import Effect

EFFECT = Effect(
    name="vibration",
    meaning="inertia of the elastic motion; without it the response is quasi-static",
    source="(5.1)",
    size=lambda survey: max(survey.vibration, 1.0) if survey.scene.impulses else survey.vibration,
    estimate="modes as oscillators under the load's harmonics",
    stated=lambda scene: scene.analysis.method == "periodic",
    without={"analysis__method": "quasi-static"},
)
