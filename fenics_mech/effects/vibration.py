"""Vibration: the inertia of the elastic motion itself. Without it the response is quasi-static."""

from fenics_mech.effects.effect import Effect, Survey


def size(survey: Survey) -> float:
    """Estimate the difference from the quasi-static response."""
    return max(survey.vibration, 1.0) if survey.needs_vibration else survey.vibration


EFFECT = Effect(
    name="vibration",
    meaning="inertia of the elastic motion; without it the response is quasi-static",
    source="(5.1)",
    size=size,
    estimate="modes as oscillators under the load's harmonics",
    stated=lambda scene: scene.analysis.method in ("periodic", "transient"),
    stated_by="analysis.method = 'periodic' or 'transient'",
    without={"analysis__method": "quasi-static"},
)
