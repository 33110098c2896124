"""Files are replaced whole, and errors name the file that was asked for."""

import errno

import pytest

from appliance.files.atomic_file import whole_file
from appliance.sizing.figures import save_figure


def test_an_error_names_the_file_and_not_a_temporary_one(tmp_path):
    with pytest.raises(FileNotFoundError) as refused, whole_file(tmp_path / "absent" / "out.csv"):
        pass
    assert refused.value.filename == str(tmp_path / "absent" / "out.csv")


def test_a_plot_that_does_not_fit_on_the_disk_is_named_and_not_half_there(tmp_path):
    class Figure:
        def savefig(self, place, **_):
            place.write_bytes(b"half of it")
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left") as refused:
        save_figure(Figure(), tmp_path / "frames.png")
    assert refused.value.filename == str(tmp_path / "frames.png")
    assert list(tmp_path.iterdir()) == []
