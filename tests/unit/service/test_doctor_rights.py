"""The doctor as an ordinary user: what only the service may do is a note and no trouble."""

import os
import tempfile

import pytest

from appliance.service import checks


@pytest.mark.parametrize(("user", "verdict"), [(1000, "note"), (0, "BAD")])
def test_a_folder_of_the_service_is_bad_news_for_root_only(tmp_path, monkeypatch, user, verdict):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    monkeypatch.setattr(os, "geteuid", lambda: user)
    found = checks._writable("disk", tmp_path, "set points are kept")
    assert found.verdict == verdict
    assert str(tmp_path) in found.text
