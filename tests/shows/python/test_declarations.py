"""What cffi knows of the library agrees with its headers: every function, and every field of every struct at its place,
as a C compiler sees them. Words are those of the command."""
import os
import pathlib
import re
import subprocess

from common import SOURCE, command, raised

import sonopack
from sonopack import _core, _records
from sonopack._native import ffi, lib

COMPILER = os.environ.get("CC", "cc")
INCLUDE = SOURCE / "include"
HEADERS = [path for path in sorted((INCLUDE / "sonopack").rglob("*.h")) if path.parent.name != "figure"]


def compiled(text):
    pathlib.Path("probe.c").write_text("#include <stddef.h>\n#include <stdio.h>\n" +
                                       "".join(f"#include <{path.relative_to(INCLUDE)}>\n" for path in HEADERS) + text)
    subprocess.run([COMPILER, "-I", str(INCLUDE), "probe.c", "-o", "probe"], check=True)
    return subprocess.run(["./probe"], check=True, text=True, capture_output=True).stdout.split()


def fields_of_header(name):
    """Names of the fields of a struct, read from its header by other means than those of the build."""
    text = "".join(path.read_text() for path in HEADERS)
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    body = re.search(rf"typedef struct {name} \{{(.*?)\n\}} {name};", text, re.S).group(1)
    return [re.search(r"(\w+)(\[\w+\])*$", part.strip()).group(1)
            for line in body.split(";") if line.strip()
            for part in re.sub(r"\(\*(\w+)\).*", r"\1", line, flags=re.S).split(",")]


def test_layout():
    structs = [name for name in ffi.list_types()[0] if ffi.typeof(name).kind == "struct" and ffi.typeof(name).fields]
    assert len(structs) > 60, structs
    lines = []
    for name in structs:
        lines.append(f'printf("%zu\\n", sizeof({name}));')
        lines += [f'printf("%zu %zu\\n", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));'
                  for field, _ in ffi.typeof(name).fields]
    numbers = iter(map(int, compiled("int main(void) {\n" + "\n".join(lines) + "\nreturn 0;\n}\n")))
    for name in structs:
        assert next(numbers) == ffi.sizeof(name), f"size of {name}"
        for field, member in ffi.typeof(name).fields:
            place = (next(numbers), next(numbers))
            assert place == (member.offset, ffi.sizeof(member.type)), (name, field, place, member.offset)


def test_fields():
    for name in ("sp_packing", "sp_contact", "sp_network", "sp_modes", "sp_signal", "sp_front", "sp_tapped_spec"):
        known = [field for field, _ in ffi.typeof(name).fields]
        assert fields_of_header(name) == known, (name, fields_of_header(name), known)
    assert list(sonopack.CONTACT.names) == fields_of_header("sp_contact"), sonopack.CONTACT
    assert list(_records.Front.__annotations__) == fields_of_header("sp_front"), _records.Front


def test_functions():
    text = "".join(re.sub(r"#define.*", "", re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S)) for path in HEADERS)
    functions = set(re.findall(r"SP_API\s[^;]*?(\w+)\(", text))
    assert len(functions) > 150 and "sp_packing_make" in functions, functions
    missing = [name for name in sorted(functions) if not callable(getattr(lib, name, None))]
    assert not missing, ("not in the extension:", missing)


def test_a_missing_field():
    """A class with a field that the header does not have cannot be made."""
    fault = raised((KeyError, RuntimeError), type, "Wrong", (_core.Owner,), {"_type": "sp_front", "t11": _core.Value()})
    assert "t11" in f"{fault}{fault.__cause__}", fault


def test_words():
    methods = list(_core.words("sp_signal_method").items())
    assert len(methods) == 8, methods
    for number, word in methods:
        assert _core.text_of(lib.sp_signal_method_name(number)) == word, (number, word)
    choices = re.findall(r"[\w-]+(?:\|[\w-]+)+", command("modes", "--help") + command("spectrum", "--help"))
    choices = [set(choice.split("|")) for choice in choices]
    for enum in ("sp_modes_solver", "sp_source", "sp_dos_method", "sp_dos_norm"):
        assert set(_core.words(enum).values()) in choices, (enum, _core.words(enum), choices)
    scene = command("help", "scene")
    for enum in ("sp_pack_kind", "sp_tapped_output", "sp_tapped_model", "sp_sizes", "sp_protocol"):
        for word in _core.words(enum).values():
            assert re.search(rf"must be [^\n]*\b{word}\b", scene), (enum, word)
