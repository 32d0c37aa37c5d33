"""Random damage to files of text and of bytes."""
import re

HOSTILE = [b"nan", b"inf", b"-inf", b"-1", b"0", b"1e308", b"-1e-320", b"99999999999999999999", b"2147483648", b"0x1p3",
           b"", b"1,5", b"top", b"\x00", b"\xff\xfe", b"%s%n", b"(" * 2000, b"9" * 5000, b"bottom", b'"', b"}", b"/*",
           b"=", b"#", b"ITEM: ATOMS id", b"3 0 0 0 0 1 1 1\n"]


def mutate(data, rng):
    """One to four faults: in a number, a line, a range of bytes, a bit, or at the end."""
    for _ in range(rng.randint(1, 4)):
        kind = rng.randrange(6)
        if kind == 0 and (numbers := list(re.finditer(rb"[-+.\w]+", data))):
            spot = rng.choice(numbers)
            data = data[:spot.start()] + rng.choice(HOSTILE) + data[spot.end():]
        elif kind == 1:
            lines = data.split(b"\n")
            i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
            if rng.random() < 0.5:
                lines[i], lines[j] = lines[j], lines[i]
            else:
                lines[i:i] = [lines[j]] * rng.choice((0, 1, 100))
                del lines[i]
            data = b"\n".join(lines)
        elif kind == 2 and data:
            start = rng.randrange(len(data))
            data = data[:start] + data[start + rng.randrange(1, 200):]
        elif kind == 3 and data:
            spot = rng.randrange(len(data))
            data = data[:spot] + bytes([data[spot] ^ 1 << rng.randrange(8)]) + data[spot + 1:]
        elif kind == 4:
            data = data[:rng.randrange(len(data) + 1)]
        else:
            spot = rng.randrange(len(data) + 1)
            data = data[:spot] + rng.choice(HOSTILE) + data[spot:]
    return data
