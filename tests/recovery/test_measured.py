"""Files of measured strains."""

import pytest

from fenics_mech.errors import SceneError
from fenics_mech.recovery.measured import read_measurement


@pytest.mark.parametrize(
    ("text", "message"),
    [("0, 1e-4\n10, 2e-4\n", "header line is missing"), ("angle, strain\n0, 250\n10, -300\n", "no strain")],
)
def test_headless_files_and_microstrain_are_refused(tmp_path, text, message):
    (tmp_path / "coupler.csv").write_text(text)
    with pytest.raises(SceneError, match=message):
        read_measurement(tmp_path / "coupler.csv")
