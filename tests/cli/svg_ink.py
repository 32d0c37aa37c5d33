"""Where the ink of an SVG figure lies, as cairo writes them: paths, glyphs and images, with their transforms and clips."""
import re
import xml.etree.ElementTree as ElementTree

SVG, LINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}href"
EVERYWHERE = (float("-inf"), float("-inf"), float("inf"), float("inf"))
IDENTITY = (1, 0, 0, 1, 0, 0)


def texts(path):
    """The texts of a figure, one an element: its letters are outlines, but its description has them."""
    description = ElementTree.parse(path).getroot().find(SVG + "desc")
    return (description.text or "").split("\n")


def _times(m, n):
    """The matrix that applies n, then m."""
    a, b, c, d, e, f = m
    g, h, i, j, k, l = n
    return a * g + c * h, b * g + d * h, a * i + c * j, b * i + d * j, a * k + c * l + e, b * k + d * l + f


def _matrix(element):
    found = re.match(r"matrix\(([^)]*)\)", element.get("transform", ""))
    return tuple(float(word) for word in re.split(r"[ ,]+", found.group(1))) if found else IDENTITY


def _box(points, m):
    x = [m[0] * p + m[2] * q + m[4] for p, q in points]
    y = [m[1] * p + m[3] * q + m[5] for p, q in points]
    return min(x), min(y), max(x), max(y)


def _points(data):
    numbers = [float(word) for word in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", data)]
    return list(zip(numbers[0::2], numbers[1::2]))


def _meet(a, b):
    return max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3])


class _Walk:
    def __init__(self, path):
        self.root = ElementTree.parse(path).getroot()
        self.by_id = {element.get("id"): element for element in self.root.iter() if element.get("id")}
        self.boxes = []

    def named(self, word):
        found = re.search(r"#([\w-]+)", word or "")
        return self.by_id.get(found.group(1)) if found else None

    def shape(self, element, m, clip, kind):
        if element.tag == SVG + "rect":
            x, y, wide, high = (float(element.get(key, 0)) for key in ("x", "y", "width", "height"))
            points = [(x, y), (x + wide, y + high)]
        elif element.tag == SVG + "image":
            points = [(0, 0), (float(element.get("width")), float(element.get("height")))]
        else:
            points = _points(element.get("d", ""))
        if points:
            box = _meet(_box(points, m), clip)
            if box[0] <= box[2] and box[1] <= box[3]:
                self.boxes.append((kind, box))

    def walk(self, element, m, clip, kind="line"):
        if element.tag in (SVG + "defs", SVG + "clipPath", SVG + "symbol"):
            return
        m = _times(m, _matrix(element))
        around = self.named(element.get("clip-path"))
        if around is not None:
            inner = [_box(_points(child.get("d", "")), m) for child in around if child.tag == SVG + "path"]
            inner += [_box([(float(child.get("x", 0)), float(child.get("y", 0))),
                            (float(child.get("x", 0)) + float(child.get("width")),
                             float(child.get("y", 0)) + float(child.get("height")))], m)
                      for child in around if child.tag == SVG + "rect"]
            for box in inner:
                clip = _meet(clip, box)
        if element.tag in (SVG + "path", SVG + "rect", SVG + "image"):
            self.shape(element, m, clip, kind)
        elif element.tag == SVG + "use":
            target = self.named(element.get(LINK) or element.get("href"))
            moved = _times(m, (1, 0, 0, 1, float(element.get("x", 0)), float(element.get("y", 0))))
            for child in target if target is not None and target.tag != SVG + "image" else [target]:
                self.walk(child, moved, clip, "letter" if target.tag == SVG + "symbol" or "glyph" in
                          (target.get("id") or "") else kind)
        for child in element:
            self.walk(child, m, clip, kind)


def ink(path):
    """[(kind, (left, top, right, bottom))] of all that is drawn, in points; kind: line or letter. The widths of lines
    do not count."""
    walk = _Walk(path)
    walk.walk(walk.root, IDENTITY, EVERYWHERE)
    return walk.boxes


def outside(path, slack=0.6):
    """What is drawn beyond the page by more than half the width of a thin line."""
    root = ElementTree.parse(path).getroot()
    _, _, wide, high = (float(word) for word in root.get("viewBox").split())
    return [(kind, box) for kind, box in ink(path)
            if box[0] < -slack or box[1] < -slack or box[2] > wide + slack or box[3] > high + slack]
