"""Compiled code is run, so that it is taken from a folder only in which nobody else could have put it."""

import logging
import os
from pathlib import Path

import pytest

from fenics_mech import _compiling
from fenics_mech._compiling import compile_safely
from fenics_mech._system import locked

NOBODY = 65534


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of one's own, with a home beside it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    _compiling._say_why.cache_clear()
    return tmp_path / "cache" / "fenics_mech"


def used(caplog):
    """Give the folder that is compiled in, and what is said."""
    caplog.clear()
    with caplog.at_level(logging.WARNING, "fenics_mech"):
        folder = compile_safely(lambda folder: folder)
    return folder, [record.getMessage() for record in caplog.records]


def test_a_folder_of_ones_own_is_made_and_used_in_silence(cache, caplog):
    before = os.umask(0o002)  # as where each user has a group of his own
    try:
        assert used(caplog) == (cache, [])
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o777 for path in (cache.parent, cache)] == [0o700, 0o700]


@pytest.mark.parametrize("mode", [0o777, 0o775, 0o722, 0o1777])
def test_a_folder_that_others_may_write_to_is_not_used(cache, caplog, mode):
    cache.mkdir(parents=True)
    cache.chmod(mode)
    folder, (said,) = used(caplog)
    assert not folder.is_relative_to(cache.parent)
    assert f"others may write to {cache}. A folder of your own" in said
    assert used(caplog)[1] == []  # it is said once
    assert list(cache.iterdir()) == []


@pytest.mark.parametrize(("mode", "taken"), [(0o777, False), (0o775, False), (0o1777, True), (0o755, True)])
def test_nor_one_that_others_may_exchange(cache, caplog, mode, taken):
    """In a folder such as /tmp, with the sticky bit, others can rename only what is theirs."""
    cache.mkdir(parents=True)
    cache.parent.chmod(mode)
    assert (used(caplog)[0] == cache) is taken


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("of_others", ["cache", "parent"])
def test_nor_one_of_another_user(cache, caplog, of_others):
    cache.mkdir(parents=True)
    os.chown(cache if of_others == "cache" else cache.parent, NOBODY, NOBODY)
    folder, (said,) = used(caplog)
    assert not folder.is_relative_to(cache.parent)
    assert "belongs to another user" in said


def test_a_link_counts_as_what_it_leads_to(cache, caplog, tmp_path):
    (tmp_path / "elsewhere" / "open").mkdir(parents=True)
    (tmp_path / "elsewhere").chmod(0o777)
    cache.parent.mkdir()
    cache.symlink_to(tmp_path / "elsewhere" / "open")
    assert not used(caplog)[0].is_relative_to(tmp_path)
    (tmp_path / "elsewhere").chmod(0o755)
    assert used(caplog)[0] == tmp_path / "elsewhere" / "open"


def test_a_lock_that_is_a_link_empties_nothing(cache, caplog, tmp_path):
    (tmp_path / "letter").write_text("dear reader")
    cache.mkdir(parents=True, mode=0o700)
    (cache / "lock").symlink_to(tmp_path / "letter")
    assert not used(caplog)[0].is_relative_to(cache.parent)
    with pytest.raises(OSError, match="symbolic links"), locked(cache / "lock"):
        pass
    assert (tmp_path / "letter").read_text() == "dear reader"


def test_a_relative_cache_is_passed_over(cache, caplog, tmp_path, monkeypatch):
    """It would count from the current folder, which may be a stranger's."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", "cache")
    assert used(caplog)[0] == tmp_path / "home" / ".cache" / "fenics_mech"
    monkeypatch.setenv("HOME", "home")
    folder, (said,) = used(caplog)
    assert not folder.is_relative_to(tmp_path)
    assert "there is no home folder" in said
    assert not Path("~").exists()
