import pytest

from pddecont.errors import InputError
from pddecont.model import parse_document


def problems(text):
    with pytest.raises(InputError) as info:
        parse_document(text, "f.yaml")
    return [(p.line, p.column, p.message) for p in info.value.problems]


def test_scalars_are_resolved_without_yaml_traps():
    data = parse_document("a: 1e-3\nb: yes\nc: 1:30\nd: '5'\ne: 0777\nf: true\ng: ~\nh: 2\n", "f.yaml").data
    assert data == {"a": 0.001, "b": "yes", "c": "1:30", "d": "5", "e": 777, "f": True, "g": None, "h": 2}


def test_positions_of_values_and_keys():
    document = parse_document("a: {b: [1,\n   x + y]}\n", "f.yaml")
    assert document.problem(("a", "b", 1), "here", offset=4).line == 2
    assert document.problem(("a", "b", 1), "here", offset=4).column == 8
    assert document.problem(("a", "b"), "key", key=True).column == 5


@pytest.mark.parametrize(
    ("text", "line", "column", "words"),
    [
        ("a: 1\nb: 2\na: 3\n", 3, 1, "stands twice"),
        ("on: 1\n", 1, 1, "means true or false"),
        ("a: [1, 2\n", 2, 1, "not valid YAML"),
        ("a: !!python/object/apply:os.getcwd []\n", 1, 4, ""),
        ("? [a, b]\n: 1\n", 1, 3, "plain name"),
        ("<<: {a: 1}\n", 1, 1, "merge keys"),
        ("- 1\n", 1, 1, "expected a mapping"),
        ("", 1, 1, "empty"),
        ("a: 1e999\n", 1, 4, "too large"),
    ],
)
def test_yaml_errors_have_a_place(text, line, column, words):
    if not words:
        assert parse_document(text, "f.yaml").data == {
            "a": []
        }  # an unknown tag on a list is ignored, and nothing is built from it
        return
    found = problems(text)
    assert (found[0][0], found[0][1]) == (line, column)
    assert words in found[0][2]


def test_alias_bomb_is_refused():
    text = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n" + "".join(
        f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 9)
    )
    assert "anchor" in problems(text)[0][2]


def test_deep_nesting_is_refused():
    assert problems("a: " + "[" * 5000 + "]" * 5000)
    assert problems("a: " + "[" * 60 + "]" * 60)
