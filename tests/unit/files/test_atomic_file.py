"""Files are replaced whole, and errors name the file that was asked for."""

import errno
import os

import pytest

from appliance.files.atomic_file import whole_file
from appliance.sizing.figures import save_figure


def test_an_error_names_the_file_and_not_a_temporary_one(tmp_path):
    with pytest.raises(FileNotFoundError) as refused, whole_file(tmp_path / "absent" / "out.csv"):
        pass
    assert refused.value.filename == str(tmp_path / "absent" / "out.csv")


@pytest.mark.parametrize("kind", ["pipe", "folder", "link to a pipe"])
def test_what_is_no_file_is_never_replaced_by_one(tmp_path, kind):
    place = tmp_path / "out.csv"
    if kind == "folder":
        place.mkdir()
    else:
        os.mkfifo(place)
    name = tmp_path / "link.csv" if kind.startswith("link") else place
    if name != place:
        name.symlink_to(place)
    with pytest.raises(OSError, match="Is a d") as refused, whole_file(name):
        pass
    assert refused.value.filename == str(name)
    assert not place.is_file()
    assert sorted(tmp_path.iterdir()) == sorted({place, name})


def test_behind_a_link_the_file_that_it_leads_to_is_replaced(tmp_path):
    (tmp_path / "rigs").mkdir()
    real, link = tmp_path / "rigs" / "today.json", tmp_path / "rig.json"
    real.write_text("old")
    link.symlink_to(real)
    with whole_file(link) as file:
        file.write("new")
    assert (link.is_symlink(), real.read_text()) == (True, "new")


def test_a_plot_that_does_not_fit_on_the_disk_is_named_and_not_half_there(tmp_path):
    class Figure:
        def savefig(self, place, **_):
            place.write_bytes(b"half of it")
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left") as refused:
        save_figure(Figure(), tmp_path / "frames.png")
    assert refused.value.filename == str(tmp_path / "frames.png")
    assert list(tmp_path.iterdir()) == []
