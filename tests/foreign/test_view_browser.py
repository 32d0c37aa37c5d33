"""The page of `sonopack view' in a browser without a network: headless Chromium finds no error in it and draws what its
address asks for.

usage: test_view_browser.py COMMAND SOURCE_DIR [FOLDER]      (with FOLDER the screenshots are kept there)
Exit status 77: there is no Chromium.
"""
import base64
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import LOOSE, expect, faults  # noqa: E402

COMMAND = str(pathlib.Path(sys.argv[1]).resolve())
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
OPTIONS = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader",
           "--enable-unsafe-swiftshader", "--hide-scrollbars", "--host-resolver-rules=MAP * ~NOTFOUND",
           "--enable-logging=stderr"]


def sonopack(*arguments):
    result = subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, stdin=subprocess.DEVNULL)
    assert result.returncode == 0, f"{' '.join(map(str, arguments))}: {result.stderr}"


def browse(page, address, *options, size=(1366, 768)):
    """What Chromium prints on stdout, and the lines of the page's console."""
    with tempfile.TemporaryDirectory(prefix="sonopack-browser-") as profile:
        result = subprocess.run([BROWSER, *OPTIONS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}",
                                 *options, f"{page.resolve().as_uri()}{address}"], text=True, capture_output=True,
                                timeout=900, errors="replace")
    assert result.returncode == 0, f"chromium: {result.returncode}: {result.stderr[-2000:]}"
    return result.stdout, [line for line in result.stderr.splitlines() if ":CONSOLE" in line]


def pixels(path):
    """The picture of a PNG file of 8 bits a channel: [height][width][channels]."""
    data, at, body = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        elif kind == b"IDAT":
            body += data[at + 8:at + 8 + size]
        at += 12 + size
    channels = {2: 3, 6: 4}[colour]
    assert depth == 8
    raw = numpy.frombuffer(zlib.decompress(body), numpy.uint8).reshape(height, 1 + width * channels)
    above, rows = numpy.zeros((width, channels), int), []
    for line in raw:
        row = line[1:].reshape(width, channels).astype(int)
        if line[0] == 1:
            row = numpy.cumsum(row, 0) & 255
        elif line[0] == 2:
            row = (row + above) & 255
        elif line[0] > 2:
            row = unfiltered(line[0], row, above)
        rows.append(row)
        above = row
    return numpy.array(rows, numpy.uint8)[..., :3]


def unfiltered(kind, row, above):
    left, corner = numpy.zeros(row.shape[1], int), numpy.zeros(row.shape[1], int)
    for k in range(len(row)):
        up = above[k]
        if kind == 3:
            guess = (left + up) // 2
        else:
            start = left + up - corner
            distances = numpy.abs(numpy.array([start - left, start - up, start - corner]))
            guess = numpy.choose(numpy.argmin(distances, 0), [left, up, corner])
        row[k] = (row[k] + guess) & 255
        left, corner = row[k], up
    return row


def shoot(page, address, name, folder, **options):
    path = folder / f"{name}.png"
    _, console = browse(page, address, f"--screenshot={path}", **options)
    expect(not console, f"{name}: {console[:3]}")
    return pixels(path)


def dom(page, address):
    text, console = browse(page, address, "--dump-dom")
    expect(not console, f"{page.name}{address}: {console[:3]}")
    return re.sub(r"<script.*?</script>", "", text, flags=re.S)


def words(text, name):
    """The text of the element with this id."""
    found = re.search(rf'<(\w+)[^>]*\bid="{name}"[^>]*>(.*?)</\1>', text, re.S)
    return re.sub(r"<[^>]*>", " ", found.group(2)) if found else ""


def picture(image):
    """The middle of the picture on a wide screen, free of legend, panel and signal."""
    return image[60:540, 320:1050]


def colours(image):
    return len(numpy.unique(image.reshape(-1, 3), axis=0))


def share(a, b):
    """Share of the pixels that differ."""
    return float((numpy.abs(a.astype(int) - b).max(-1) > 8).mean())


# ---- checks ---------------------------------------------------------------------------------------------------------


def check_the_checker(page, folder):
    """A page whose data are damaged fails, and both its console and its own words say so."""
    broken = folder / "broken.html"
    broken.write_text(page.read_text().replace('"packings":[', '"packings":[;'))
    text, console = browse(broken, "", "--dump-dom")
    assert console and 'data-state="failed"' in text, "an error in the page is not seen"


def check_views(name, page, folder):
    """All views: drawn, and different from each other as they should be."""
    still = shoot(page, "#packing=1", f"{name}-packing", folder)
    expect(colours(picture(still)) > 200, f"{name}: the packing has {colours(picture(still))} colours")
    modes = [shoot(page, f"#mode={k}&t={t}", f"{name}-mode{k}-{t}", folder) for k, t in ((3, 0), (3, 0.5), (1, 0))]
    expect(share(picture(modes[0]), picture(modes[1])) > 0.02, f"{name}: the mode does not swing")
    expect(share(picture(modes[0]), picture(modes[2])) > 0.02, f"{name}: two modes look the same")
    wave = [shoot(page, f"#wave&t={t}", f"{name}-wave-{t}", folder) for t in (5, 25)]
    expect(share(picture(wave[0]), picture(wave[1])) > 0.02, f"{name}: the wave does not move")
    curve = wave[1][580:740, 80:1040].astype(int)
    expect(((curve[..., 2] - curve[..., 0]) > 60).sum() > 300, f"{name}: no curve of the signal")
    phone = shoot(page, "#wave&t=25", f"{name}-phone", folder, size=(390, 844))
    expect(colours(phone) > 200, f"{name}: {colours(phone)} colours on a phone")


def check_words(name, page):
    if name in ("plane", "space"):
        check_legends(name, page)
    text = dom(page, "#mode=3&t=0.25")
    expect('data-state="ready"' in text and 'data-view="mode"' in text, f"{name}: the page does not start")
    expect("0.25 of a period" in words(text, "time-words"), f"{name}: time {words(text, 'time-words')}")
    expect("ω" in words(text, "modes") and "zero modes" in words(text, "mode-words"), f"{name}: modes")
    expect("over the largest" in words(text, "legend"), f"{name}: legend of a mode {words(text, 'legend')}")
    for word in ("NaN", "undefined", "Infinity"):
        expect(word not in text, f"{name}: {word} in the page")


def check_legends(name, page):
    text = dom(page, "#wave&t=25")
    expect("t = 25 d/√(E*/ρ)" in words(text, "time-words"), f"{name}: time {words(text, 'time-words')}")
    expect(re.search(r"Displacement.*\[d\]", words(text, "legend"), re.S), f"{name}: legend of the wave")
    text = dom(page, "#packing=1")
    expect("Normal force [E* d²]" in words(text, "legend"), f"{name}: legend {words(text, 'legend')}")
    for word in ("NaN", "undefined", "Infinity"):
        expect(word not in text, f"{name}: {word} in the page")


def check_missing(page):
    text = dom(page, "#wave")
    expect("no wave" in words(text, "reason") and "wall" in words(text, "reason"), f"no walls: {words(text, 'reason')}")
    expect('data-state="ready"' in text, "no walls: the page does not start")


def check_saved(page, folder):
    """The picture that "Save PNG" saves is that of the page, with its legend and the signal."""
    probe = folder / "probe.html"
    probe.write_text(page.read_text().replace("</body>", """<script type="module">
document.documentElement.dataset.saved = window.sonopack.picture().toDataURL('image/png');</script></body>"""))
    text, console = browse(probe, "#wave&t=25", "--dump-dom")
    found = re.search(r'data-saved="data:image/png;base64,([^"]+)"', text)
    if not found:
        faults.append(f"no picture is saved: {console[:3]}")
        return
    (folder / "saved.png").write_bytes(base64.b64decode(found.group(1)))
    saved = pixels(folder / "saved.png")
    width = saved.shape[1]
    corner, middle, below = saved[-460:-200, :280], saved[20:-240, width // 3:], saved[-180:-50, 80:-20].astype(int)
    expect(colours(middle) > 200, f"the saved picture has {colours(middle)} colours")
    expect(colours(corner) > 100, f"the legend of the saved picture has {colours(corner)} colours")
    expect(((below[..., 2] - below[..., 0]) > 60).sum() > 300, "the saved picture has no curve of the signal")


def frames_a_second(page):
    rate = re.search(r'data-frames-per-second="([\d.]+)"', dom(page, "#wave&t=0&measure=5"))
    expect(rate and float(rate.group(1)) > 0, "no frames are counted")
    return rate.group(1) if rate else "?"


def main():
    if not BROWSER:
        print("no Chromium")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="sonopack-view-") as scratch:
        folder = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else pathlib.Path(scratch)
        for name, keys in (("plane", ("grains=80", "width=8")), ("smooth", ("grains=60", "width=8", "friction=0")),
                           ("space", ("grains=90", "width=5", "dimension=3", 'protocol="quick"'))):
            sets = [word for key in keys for word in ("--set", f"packing.{key}")]
            sonopack("pack", "-q", *sets, "--force", "-o", folder / f"{name}.h5")
            sonopack("view", folder / f"{name}.h5", "--force", "-o", folder / f"{name}.html")
        sonopack("pack", "-q", "--set", 'packing.kind="chain"', "--set", "packing.grains=20", "--force", "-o",
                 folder / "chain.h5")
        sonopack("view", folder / "chain.h5", "--force", "-o", folder / "chain.html")
        (folder / "loose.txt").write_text(LOOSE)
        sonopack("view", folder / "loose.txt", "-q", "--force", "-o", folder / "loose.html")
        check_the_checker(folder / "plane.html", folder)
        for name in ("plane", "space"):
            check_views(name, folder / f"{name}.html", folder)
        for name in ("plane", "smooth", "space", "chain"):
            check_words(name, folder / f"{name}.html")
        check_missing(folder / "loose.html")
        check_saved(folder / "plane.html", folder)
        print("frames a second of 80 grains:", frames_a_second(folder / "plane.html"))
    print(*faults, sep="\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
