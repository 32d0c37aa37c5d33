"""The manual page and the completions know every command and every long option that the command's own help names.

usage: test_manual.py COMMAND SOURCE_DIR
"""
import pathlib
import re
import subprocess
import sys

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
COMMANDS = """pack check statics moduli modes spectrum signal front wave transport amplitude chain sensitivity uncertainty
    coda design study table reproduce column plot view convert bench completion""".split()


def output(*arguments):
    result = subprocess.run([COMMAND, *arguments], text=True, capture_output=True, stdin=subprocess.DEVNULL)
    assert result.returncode == 0, f"sonopack {' '.join(arguments)}: {result.returncode}: {result.stderr}"
    return result.stdout


def options(command):
    found = set(re.findall(r"^ +(?:-\w, )?(--[a-z][a-z0-9-]*)", output(command, "--help"), re.M))
    found |= set(re.findall(r"^ +--[^,\n]+, (--[a-z][a-z0-9-]*)", output(command, "--help"), re.M))
    return found - {"--help", "--usage", "--version"}


def completions(*words):
    """What bash offers for the last word."""
    line = " ".join(f"'{word}'" for word in (COMMAND, *words))
    script = (f"source <('{COMMAND}' completion bash); COMP_WORDS=({line}); COMP_CWORD={len(words)}; "
              "_sonopack 2>/dev/null; printf '%s\\n' \"${COMPREPLY[@]}\"")
    result = subprocess.run(["bash", "-c", script], text=True, capture_output=True, cwd=SOURCE)
    assert result.returncode == 0 and not result.stderr, result
    return set(result.stdout.split())


def versions():
    """The version that each file names."""
    for name, pattern in (("include/sonopack/version.h", r'SONOPACK_VERSION "([^"]+)"'), ("CHANGELOG.md", r"^## (\S+)"),
                          ("CITATION.cff", r"^version: \"?([^\"\s]+)"), ("docs/man/sonopack.1", r'"sonopack ([^"]+)"')):
        yield name, re.search(pattern, (SOURCE / name).read_text(), re.M).group(1)


def main():
    faults = []
    if len({version for _, version in versions()}) > 1:
        faults.append(f"files name different versions: {dict(versions())}")
    page = (SOURCE / "docs/man/sonopack.1").read_text().replace("\\-", "-")
    overview = output("help")
    for command in COMMANDS:
        if not re.search(rf"^\s*{command}\b", overview, re.M):
            faults.append(f"sonopack help does not name {command}")
        if not re.search(rf"^\.(SS|B|BI|BR) \"?{command}\b", page, re.M):
            faults.append(f"the manual page does not explain {command}")
        if command not in completions(command[:2]):
            faults.append(f"the completion does not offer {command}")
        named = options(command)
        if not named:
            faults.append(f"sonopack {command} --help names no option")
        for option in sorted(named):
            if not re.search(rf"{option}\b", page):
                faults.append(f"the manual page does not know {option} of {command}")
        missing = named - completions(command, "--")
        if missing:
            faults.append(f"the completion of {command} lacks {sorted(missing)}")
    for option in sorted(set(re.findall(r"--[a-z][a-z0-9-]*", page)) - {"--help", "--version"}):
        if not any(option in options(command) for command in COMMANDS):
            faults.append(f"the manual page names {option}, which no command has")
    own, lammps = output("pack", "--help").split("Packings that LAMMPS makes")
    if "--dry-run" not in own or "--dry-run" in lammps.split("Common options:")[0]:
        faults.append("the help of pack has --dry-run among the options of LAMMPS")
    version = output("--version").split()[-1]
    if version not in page.split("\n")[0] + page:
        faults.append(f"the manual page is not of version {version}")
    if "README.md" not in completions("check", "README"):
        faults.append("the completion offers no files")
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
