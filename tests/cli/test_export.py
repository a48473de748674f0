"""Tables into files: what is there is replaced only by its like."""

import json

import pytest

from tests.cli.test_cli import QUICK_TEXT, call


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exported")
    (folder / "quick.yaml").write_text(QUICK_TEXT)
    assert call("run", folder / "quick.yaml", "-o", folder / "quick.h5", "-q")[0] == 0
    return folder / "quick.h5"


def test_a_file_holds_what_would_be_written_to_standard_output(results, tmp_path):
    for name, options in (("t.csv", ()), ("t.json", ("--format", "json")), ("t.txt", ("--format", "csv"))):
        _, out, _ = call("export", results, *options)
        code, silent, said = call("export", results, "-o", tmp_path / name, *options)
        assert (code, silent, said) == (0, "", f"table: {tmp_path / name}\n")
        assert (tmp_path / name).read_text() == out


def test_the_suffix_says_the_format_unless_it_is_given(results, tmp_path):
    call("export", results, "-o", tmp_path / "t.json")
    assert json.loads((tmp_path / "t.json").read_text())
    call("export", results, "-o", tmp_path / "u.json", "--format", "csv")
    assert (tmp_path / "u.json").read_text().startswith("index,label,")


@pytest.mark.parametrize("name", ["t.csv", "t.json"])
def test_a_table_of_the_same_columns_is_replaced_and_nothing_else(results, tmp_path, name):
    path = tmp_path / name
    assert call("export", results, "-o", path)[0] == 0
    whole = path.read_text()
    path.write_text(whole[: len(whole) // 2])
    assert call("export", results, "-o", path)[0] == 0
    assert path.read_text() == whole
    for other in ("notes of mine\n", "index,other\n1,2\n", '[{"other": 1}]', "name: model\n"):
        path.write_text(other)
        code, _, err = call("export", results, "-o", path)
        assert code == 1 and "is not such a table" in err
        assert path.read_text() == other
    link = tmp_path / f"link_{name}"
    link.symlink_to(path)
    assert call("export", results, "-o", link)[0] == 1 and path.read_text() == "name: model\n"


def test_a_table_without_rows_replaces_only_what_is_empty(results, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("mine")
    options = ("--step", "branch", "--table", "special", "-o", path)
    code, _, err = call("export", results, *options)
    assert (code, path.read_text()) == (1, "mine"), err
