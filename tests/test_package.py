"""What a release of the package is made from."""

import re
import shutil
import subprocess
import tomllib

from tests.common import ROOT


def test_a_release_has_the_address_of_its_repository_in_links_and_pictures(tmp_path):
    shutil.copytree(ROOT / ".ci", tmp_path / ".ci")
    for name in ("README.md", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    subprocess.run([tmp_path / ".ci" / "addressed", "https://forge.test/owner/fenics_mech", "v1.2"], check=True)
    before, after = ((folder / "README.md").read_text() for folder in (ROOT, tmp_path))
    places = {"raw": r'<img src="([^"]+)"', "blob": r"\]\(([^)]+)\)"}
    for kind, place in places.items():
        found = re.findall(place, before)
        assert found
        assert all((ROOT / path).exists() for path in found)
        assert re.findall(place, after) == [
            f"https://forge.test/owner/fenics_mech/{kind}/v1.2/{path}" for path in found
        ]
    project = tomllib.loads((tmp_path / "pyproject.toml").read_text())["project"]
    assert project["urls"]["Repository"] == "https://forge.test/owner/fenics_mech"
    assert project == tomllib.loads((ROOT / "pyproject.toml").read_text())["project"] | {"urls": project["urls"]}
