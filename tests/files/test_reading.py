"""Files that are given: only regular ones of a bearable size are read, whatever they are said to hold."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from inverse import certify, spec
from inverse.context import read_city_json
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.reading import read_bytes, read_text
from inverse.repair.foreign import read_foreign

READERS = {
    "design.fold": fold_file.read,
    "check.fold": certify.check,
    "pattern.fold": read_foreign,
    "pattern.obj": read_foreign,
    "spec.yaml": spec.load,
    "site.city.json": read_city_json,
}


@pytest.mark.parametrize("name", READERS)
def test_every_reader_refuses_what_is_no_file(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    with pytest.raises(InputError, match=f"{name}: there is no such file"):
        READERS[name](path)
    os.mkfifo(path)
    with pytest.raises(InputError, match=f"{name}: this is a device, pipe or socket"):
        READERS[name](path)
    path.unlink()
    path.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="this is a device, pipe or socket"):
        READERS[name](path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match="this is a folder, not a file"):
        READERS[name](path)
    path.rmdir()
    path.touch()
    with pytest.raises(InputError, match="the file is empty"):
        READERS[name](path)
    with path.open("wb") as file:
        file.truncate(10**12)  # takes no space
    with pytest.raises(InputError, match=r"the file is larger than 10+ MB"):
        READERS[name](path)
    long = tmp_path / ("a" * 300 + path.suffix)
    with pytest.raises(InputError, match="the file cannot be read: File name too long"):
        READERS[name](long)


def test_text_and_where_it_is_none(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xef\xbb\xbfk: v\r\n")
    assert read_text(path, 100) == "k: v\r\n"
    assert read_bytes(path, 100)[:1] == b"\xef"
    path.write_bytes("grün\nblä".encode("latin-1"))
    with pytest.raises(InputError, match=r"a\.txt:1:3: the byte 0xfc is not valid UTF-8"):
        read_text(path, 100)
    with pytest.raises(InputError, match=r"there is no such file\. Did you mean a\.txt"):
        read_text(tmp_path / "b.txt", 100)
