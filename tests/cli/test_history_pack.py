"""packing.tangential and network.tangential: the packing names its law, the networks bound each other, and what cannot say
which law it has is refused.

usage: test_history_pack.py COMMAND SOURCE_DIR
"""
import pathlib

from command import main, pack, refused, run, table

SMALL = {"grains": 60, "width": 7, "tolerance": 1e-9}


def laws():
    one, same, history = (pathlib.Path(pack(f"{name}.h5", **SMALL, **keys)).read_bytes() for name, keys in (
        ("c", {}), ("same", {"tangential": "constant"}), ("h", {"tangential": "history"})))
    assert one == same != history and table("check", "h.h5").words("ok") == ["yes"]
    speed = [table("moduli", "h.h5", f"--set=network.tangential={word}")["c_t"][0]
             for word in ("constant", "loading", "lowest")]
    assert speed[0] > speed[1] > speed[2] > 0.5 * speed[0], speed
    assert run("moduli", "h.h5").stdout == run("moduli", "h.h5", "--set=network.tangential=constant").stdout
    # a stored packing goes on to another pressure with its forces as those of first loading
    pack("more.h5", kind="file", file="h.h5", pressure=2e-4, tangential="history", tolerance=1e-9)
    assert table("check", "more.h5").words("ok") == ["yes"]


def refusals():
    for words in (["--vectors", "v.h5"], ["--lowest", "2", "--vectors", "v.tsv", "--mode", "13"]):
        refused("network.tangential", "modes", "h.h5", *words, "--set=network.tangential=loading", status=1)
    assert not list(pathlib.Path().glob("v.*"))
    refused("packing.tangential", "pack", "--set=packing.tangential=mindlin", "-o", "no.h5")
    refused("network.tangential", "moduli", "h.h5", "--set=network.tangential=history")
    refused("packing.tangential", "pack", "--set=packing.dimension=3", "--set=packing.tangential=history", "-o", "no.h5")


main(laws, refusals)
