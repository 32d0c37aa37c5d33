"""Makes the generated parts of the Python package from the public headers.

usage: generate.py INCLUDE_DIR NATIVE_HEADER OUTPUT_DIR

_native.c      source of the extension module, written by cffi from the declarations of the headers
_records.py    a frozen dataclass for each struct that holds numbers and words only
_fields.py     a class for each struct that an object of Python owns, with its numbers and arrays
_reference.py  the comments of the headers, from which docstrings are made

Nothing is copied by hand: a change of a header changes all three, and the C compiler compares each struct with the
header once more when it compiles _native.c.
"""
import keyword
import pathlib
import re
import sys
import textwrap

import cffi

# What the library calls back; implemented in sonopack/_watch.py.
CALLBACKS = """
extern "Python" {
    bool sonopack_pack_watch(const sp_pack_progress *progress, void *user);
    bool sonopack_study_watch(const sp_study_progress *progress, void *user);
    bool sonopack_tapped_watch(double share, void *user);
    bool sonopack_tapped_stopped(void *user);
    sp_status sonopack_tapped_row(double t, const double *y, const double *v, void *user, sp_error *err);
}
void sonopack_blas_begin(void);
void sonopack_blas_end(void);
char *strdup(const char *text);
"""
# Structs of this kind are inputs of the library and no results.
INPUTS = re.compile(r"_(options|spec|range|place|hooks|pulse|probe|watcher|made|counts|entry|column|sweep|error|chain|value|errors|store_check|finding)$")

# Structs that objects own, and what of them is no member: parts that the object gives in another way.
OWNED = {"sp_packing": "n_contacts mass inertia species box tilt strain", "sp_modes": "dofs vectors factors solves", "sp_damped_modes": "",
         "sp_complex_modes": "dofs right right_im left left_im", "sp_response": "", "sp_local_moduli": "", "sp_clusters": "",
         "sp_network": "n_all rattlers n_springs box prestress omega_bound carried skew soft tilt", "sp_signal": "",
         "sp_dos": "", "sp_transmission": "", "sp_dispersion": "", "sp_harmonic": "refused reason", "sp_continuum": "",
         "sp_coherent_section": "", "sp_uncertainty": "n quantity", "sp_design": "packing", "sp_coda": ""}


def headers(include):
    """The public headers in the order in which they include each other, but for the figures."""
    found = []

    def visit(path):
        if path in found:
            return
        for name in re.findall(r"^#include <(sonopack/[^>]+)>", path.read_text(), re.M):
            visit(include / name)
        found.append(path)

    for path in sorted((include / "sonopack").rglob("*.h")):
        if path.parent.name != "figure":
            visit(path)
    return found


def without_preprocessor(text):
    """Declarations and comments alone: no directives, no `extern "C"`, no visibility, no attributes."""
    text = re.sub(r"^#ifdef __cplusplus\n.*?^#endif\n", "", text, flags=re.S | re.M)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*\n", "\n", text, flags=re.M)
    text = re.sub(r"__attribute__\s*\(\((?:[^()]|\([^()]*\))*\)\)", "", text)
    return re.sub(r"\bSP_(API|SHARED)\b", "", text)


def without_comments(text):
    return re.sub(r"/\*.*?\*/", " ", text, flags=re.S)


# ---- comments -------------------------------------------------------------------------------------------------------

def plain(comment):
    """The sentences of a comment; "" for a line that only divides a header into parts."""
    text = re.sub(r"\n[ \t]*\*?[ \t]*", "\n", comment[2:-2].strip("* \n"))
    if re.match(r"-{3,}", text):
        return ""
    return re.sub(r"(?<!\n)\n(?!\n)", " ", text).strip()


def name_of(code):
    """What a declaration declares: a function, a type, or None for a bare enum."""
    code = without_comments(code)
    typedef = re.search(r"typedef\b.*\}\s*(\w+)\s*;$", code, re.S)
    pointer = re.search(r"typedef[^{]*\(\s*\*\s*(\w+)\s*\)\s*\(", code)
    function = re.match(r"[^({]*?(\w+)\s*\(", code)
    for match in (typedef, pointer, function if "typedef" not in code else None):
        if match:
            return match.group(1)
    return None


FIELD = re.compile(r"(?P<above>(?:\s*/\*(?:(?!\*/).)*\*/)*)(?P<code>[^;/]+);(?P<behind>[ \t]*/\*.*?\*/)?", re.S)
BRACKETS = re.compile(r" ?\[(?:[^\]]*(?:E\*|\brho\b)[^\]]*|(?:1/)?d(?:\^\d)?)\]")


def field_comments(code):
    """{field: comment} of a struct: the comment behind a declaration, or above it. Of several fields that are declared
    together each has its own part, where the comment has as many parts between semicolons; the shape at its beginning,
    the sentences behind the last part, and the unit at its end belong to all of them."""
    body = re.search(r"\{(.*)\}", code, re.S)
    if "typedef struct" not in code or not body:
        return {}
    found = {}
    for match in FIELD.finditer(body.group(1)):
        names = re.findall(r"(\w+)\s*(?:\[[^\]]*\]\s*)*(?:,|$|\)\s*\()", match["code"])
        comment = match["behind"] or (re.findall(r"/\*.*?\*/", match["above"], re.S) or [""])[-1]
        for name, text in zip(names, parts_of(plain(comment.strip()) if comment else "", len(names))):
            found[name] = text
    return {name: text for name, text in found.items() if text}


def parts_of(comment, count):
    parts = comment.split("; ")
    if count == 1 or len(parts) != count:
        return [comment] * count
    shape = re.match(r"(?:\[[^\]]*\])* ?", comment).group()
    unit = BRACKETS.search(parts[-1]) if parts[-1].endswith("]") else None
    body = parts[-1][:unit.start()] if unit else parts[-1]
    last, stop, rest = (*re.split(r"(?<!\.)(\. )", body, maxsplit=1), "", "")[:3]
    own = [parts[0][len(shape):], *parts[1:-1], last]
    return [shape + text + stop + rest + (unit.group() if unit and not BRACKETS.search(text) else "") for text in own]


# ---- C's words ------------------------------------------------------------------------------------------------------

SPOKEN = ((r"\bSP_EINVAL\b|\bSP_EFORMAT\b", "InvalidInput"), (r"\bSP_EIO\b", "FileError"), (r"\bSP_ENOMEM\b", "NoMemory"),
          (r"\bSP_EREFUSED\b", "Refused"), (r"\bSP_EINTERRUPTED\b", "Interrupted"), (r"\bSP_EFAILED\b", "SonopackError"),
          (r"[-+]?\bINFINITY\b", "inf"), (r"\bNAN\b", "nan"), (r"(?:^|(?<=\. ))\w+ may be NULL\. ?", ""),
          (r"[,;]?(?: either of which)?(?: which)?(?: ?\bmay be NULL\b)", ""), (r",? or NULL\b", ""), (r"\bNULL\b", "None"),
          (r"\bSP_(?:CELL|WALL|PLACE|SIGNAL|PACK|DAMPING)_([A-Z_]+)\b", lambda m: m[1].lower().replace("_", "-")),
          (r"\bSP_([A-Z_]+)\b", r"\1"))


def spoken(text, names):
    """A comment in the words of Python: its exceptions, its classes and methods."""
    for pattern, word in SPOKEN:
        text = re.sub(pattern, word, text)
    return re.sub(r"\bsp_\w+", lambda match: names.get(match[0], match[0]), text).strip()


def python_names(package):
    """{name in C: name in Python} of classes and of what has the comment of a C function."""
    names, structs = {}, {python_name(name): name for name in OWNED}
    for path in package.glob("_*.py"):
        owner, documented = "", None
        for line in path.read_text().splitlines():
            kind = re.match(r"class (\w+)(?:.*_fields\.(\w+))?", line)
            function, comment = re.match(r"( *)def (\w+)", line), re.match(r" *@documented\(\"(\w+)\"\)", line)
            if kind:
                owner = kind[1]
                names.update({structs[kind[2]]: owner} if kind[2] else {})
            elif function and documented:
                names.setdefault(documented, f"{owner}.{function[2]}()" if function[1] else f"{function[2]}()")
                documented = None
            elif comment:
                documented = comment[1]
    return names


def unit_of(comment):
    """The unit that a comment has in brackets, in E*, rho and d; "" for a pure number."""
    found = BRACKETS.findall(comment)
    return found[0].strip(" []") if len(found) == 1 else ""


DECLARATION = re.compile(r"(?P<before>(?:/\*(?:(?!\*/).)*\*/\s*)*)"
                         r"(?P<code>\s*(?:typedef\s+(?:struct|enum)\s+\w*\s*\{.*?\n?\}\s*\w+\s*;|[^;{}/]+;))"
                         r"(?P<after>[ \t]*/\*.*?\*/)?", re.S)


def comments_of(text, reference):
    """Adds the comments of one header. A comment belongs to the declaration below it, and to those that follow without a
    blank line; or to the one on whose last line it stands. One with a blank line below is about the file or a part of
    it."""
    above = ""
    for match in DECLARATION.finditer(text):
        before, code, after = match["before"], match["code"], match["after"]
        comments = re.findall(r"/\*.*?\*/", before, re.S)
        if comments:
            above = "" if re.search(r"\n\s*\n\s*$", before) else plain(comments[-1])
        elif "\n\n" in code[:len(code) - len(code.lstrip())] or "typedef" in code:
            above = ""
        own, fields = plain(after.strip()) if after else above, field_comments(code)
        name = name_of(code)
        if name and not name.endswith("_free") and (own or fields):
            reference[name] = (own, fields)


# ---- quantities -----------------------------------------------------------------------------------------------------

def quantities(text, reference):
    """The members of a result are what quantities.inc says of them: meaning and unit."""
    for struct, member, _, unit, meaning in re.findall(r'^(\w+)\((\w+), "([^"]*)", "([^"]*)", "([^"]*)"\)$', text, re.M):
        own, fields = reference.get(f"sp_{struct.lower()}", ("", {}))
        reference[f"sp_{struct.lower()}"] = own, {**fields, member: meaning + (f" [{unit}]" if unit else "")}


# ---- records --------------------------------------------------------------------------------------------------------

def python_name(c_name):
    """sp_probe_moduli becomes ProbeModuli."""
    return "".join(word.capitalize() for word in c_name.removeprefix("sp_").split("_"))


def python_type(ffi, ctype, records):
    if ctype.kind == "primitive":
        if ctype.cname in ("double", "float"):
            return "float"
        return {"_Bool": "bool"}.get(ctype.cname, "int" if ctype.cname != "char" else None)
    if ctype.kind == "enum":
        return "str"
    if ctype.kind == "array" and ctype.item.cname == "char":
        return "str"
    if ctype.kind == "pointer" and ctype.item.cname == "char":
        return "str"
    if ctype.kind == "struct" and ctype.cname in records:
        return python_name(ctype.cname)
    return None


def doc_of(own, fields):
    """Text of a docstring that is indented by four."""
    lines = textwrap.wrap(own, 110) + [""]
    for name, comment in fields:
        lines += textwrap.wrap(f"{name}: {comment}", 110, subsequent_indent="    ")
    text = "\n".join("    " + line if line else "" for line in lines).strip()
    return text.replace("\\", "\\\\").replace('"""', "'''")


def records_of(ffi, names, reference):
    """Source of _records.py: structs all of whose fields are numbers, words, or such structs."""
    records, blocks = {}, []
    for name in names:
        if INPUTS.search(name):
            continue
        ctype = ffi.typeof(name)
        types = [(field, python_type(ffi, member.type, records)) for field, member in ctype.fields]
        if not all(kind for _, kind in types):
            continue
        records[name] = True
        own, fields = reference.get(name, ("", {}))
        text = doc_of(own,
                      [(field, fields[field]) for field, _ in types if field in fields])
        body = "\n".join(f"    {field + '_' if keyword.iskeyword(field) else field}: {kind}" for field, kind in types)
        body += f"\n    units = {({field: unit_of(text) for field, text in fields.items() if unit_of(text)})!r}"
        blocks.append(f'@dataclass(frozen=True)\nclass {python_name(name)}(InSI):\n    """{text}\n    """\n\n{body}\n')
    table = "".join(f'    "{name}": {python_name(name)},\n' for name in records)
    return ('"""Results of the library as plain values. Generated from its headers."""\n'
            "from dataclasses import dataclass\n\nfrom ._si import InSI\n\n\n" + "\n\n".join(blocks) +
            f"\n\nRECORDS: dict[str, type] = {{\n{table}}}\n")


def fields_of(ffi, reference):
    """Source of _fields.py: numbers, words and records as they are, arrays with the shape at the beginning of their
    comment: [n][3]."""
    records = {name for name in ffi.list_types()[0] if name.startswith("sp_")}
    blocks = []
    for name, hidden in OWNED.items():
        lines = [f'    _type = "{name}"']
        for field, member in ffi.typeof(name).fields:
            if field in hidden.split():
                continue
            kind = python_type(ffi, member.type, records)
            shape = re.findall(r"\[([^\]]+)\]", re.match(r"(\[[^\]]+\])*", reference[name][1].get(field, "")).group())
            sizes = "".join(re.sub(r"\b([a-z]\w*)", r"c.\1", size) + ", " for size in shape)
            lines.append(f"    {field} = " + (f"Value[{kind.replace('.', '')}]()" if kind else f"Array(lambda c: ({sizes}))"))
        blocks.append(f"class {python_name(name)}(Result):\n" + "\n".join(lines) + "\n")
    used = sorted(set(re.findall(r"Value\[([A-Z]\w*)\]", "".join(blocks))))
    return ('"""What objects own of the library. Generated from its headers."""\nfrom ._core import Array, Result, Value\n'
            f"from ._records import {', '.join(used)}\n\n\n" + "\n\n".join(blocks))


def main():
    include, native, output = map(pathlib.Path, sys.argv[1:4])
    reference, code = {}, []
    for path in headers(include):
        text = without_preprocessor(path.read_text())
        comments_of(text, reference)
        code.append(without_comments(text))
    quantities((include / "sonopack/quantities.inc").read_text(), reference)
    names = python_names(native.parent / "sonopack")
    names.update((name, python_name(name)) for name in reference if reference[name][1] and not INPUTS.search(name))
    reference = {name: (spoken(own, names), {field: spoken(text, names) for field, text in fields.items()})
                 for name, (own, fields) in reference.items()}
    declarations = "".join(code)
    # cffi writes C that does not compile for a pointer to an array of constants; such fields are left out
    declarations = re.sub(r"const \w+ \(\*\w+\)\[\w+\];", "...;", declarations)
    ffi = cffi.FFI()
    ffi.cdef(declarations + CALLBACKS)
    names = re.findall(r"typedef struct (\w+) \{", declarations)
    includes = "".join(f"#include <{path.relative_to(include)}>\n" for path in headers(include))
    ffi.set_source("sonopack._native", includes + native.read_text())
    output.mkdir(parents=True, exist_ok=True)
    ffi.emit_c_code(str(output / "_native.c"))
    (output / "_records.py").write_text(records_of(ffi, names, reference))
    (output / "_fields.py").write_text(fields_of(ffi, reference))
    (output / "_reference.py").write_text(
        '"""Comments of the C headers: {name: (comment, {field: comment})}, and {struct: {field: unit}}. Generated."""\n'
        f"COMMENTS: dict[str, tuple[str, dict[str, str]]] = {{\n"
        + "".join(f"    {name!r}: {entry!r},\n" for name, entry in sorted(reference.items())) + "}\n\n"
        "UNITS: dict[str, dict[str, str]] = {\n"
        + "".join(f"    {name!r}: { {field: unit_of(text) for field, text in fields.items() if unit_of(text)}!r},\n"
                  for name, (_, fields) in sorted(reference.items()) if fields) + "}\n")


if __name__ == "__main__":
    main()
