"""packing.tangential and network.tangential on the command line: the packing names its law, the networks bound each other,
and what cannot say which law it has is refused.

usage: test_history_pack.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

COMMAND = str(pathlib.Path(sys.argv[1]).resolve())
SMALL = ["--set", "packing.grains=60", "--set", "packing.width=7", "--set", "packing.tolerance=1e-8"]


def run(*words, status=0, cwd=None):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=cwd)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done.stderr if status else done.stdout


def last(text):
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return dict(zip(lines[0], lines[-1]))


def main(folder):
    run("pack", *SMALL, "-o", "c.h5", "-q", cwd=folder)
    run("pack", *SMALL, "--set", "packing.tangential=constant", "-o", "same.h5", "-q", cwd=folder)
    run("pack", *SMALL, "--set", "packing.tangential=history", "-o", "h.h5", "-q", cwd=folder)
    assert (folder / "c.h5").read_bytes() == (folder / "same.h5").read_bytes()
    assert (folder / "c.h5").read_bytes() != (folder / "h.h5").read_bytes()
    assert last(run("check", "h.h5", cwd=folder))["ok"] == "yes"
    speed = [float(last(run("moduli", "h.h5", "--set", f"network.tangential={word}", cwd=folder))["c_t"])
             for word in ("constant", "loading", "lowest")]
    assert speed[0] > speed[1] > speed[2] > 0.5 * speed[0], speed
    assert run("moduli", "h.h5", cwd=folder) == run("moduli", "h.h5", "--set", "network.tangential=constant", cwd=folder)
    for words, status in ((["modes", "h.h5", "--vectors", "v.h5"], 1),
                          (["modes", "h.h5", "--lowest", "2", "--vectors", "v.tsv", "--mode", "16"], 1)):
        assert "network.tangential" in run(*words, "--set", "network.tangential=loading", status=status, cwd=folder)
    assert not (folder / "v.h5").exists()
    assert "packing.tangential" in run("pack", "--set", "packing.tangential=mindlin", "-o", "no.h5", status=2, cwd=folder)
    assert "network.tangential" in run("moduli", "h.h5", "--set", "network.tangential=history", status=2, cwd=folder)
    assert "packing.tangential" in run("pack", "--set", "packing.dimension=3", "--set", "packing.tangential=history",
                                       "-o", "no.h5", status=2, cwd=folder)
    # a stored packing goes on to another pressure with its forces as those of first loading
    run("pack", "--set", "packing.kind=file", "--set", "packing.file=h.h5", "--set", "packing.pressure=2e-4", "--set",
        "packing.tangential=history", "--set", "packing.tolerance=1e-8", "-o", "more.h5", "-q", cwd=folder)
    assert last(run("check", "more.h5", cwd=folder))["ok"] == "yes"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        main(pathlib.Path(name))
    print("passed")
