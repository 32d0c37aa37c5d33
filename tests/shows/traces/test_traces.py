"""sonopack trace: files of instruments; arrivals, speeds and errors in a synthetic laboratory; transfer functions of lattices whose
dispersion and loss are known in closed form; the fit of a computed signal."""
import math
import re
import struct

import numpy as np
import pytest

import sonopack
from sonopack import Table
from sonopack._command import Failed
from sonopack.traces import Response, Trace, against, arrivals, command, line, read, transfer
from sonopack.traces.read import Form

SEED, SPEED = 20261129, 250.0  # m/s of the laboratory
WAYS = ("t10", "t_aic", "t_xcorr", "t_peak")


# ---- the laboratory -------------------------------------------------------------------------------------------------

@pytest.fixture(scope="session")
def computed():
    """The signal of a packing, in us."""
    packing = sonopack.Packing.make(sonopack.Scene(packing={"grains": 200, "seed": 2}))
    signal = packing.network().signal(points=8001)
    return signal.t * 0.2, signal.f[0, 0] / signal.f.max()


def case(computed, noise, random):
    """Four traces of one signal at exact delays, with an offset, a trigger that is wrong by up to 20 us, and noise that is a part
    of the first peak; and t10, t_peak and Akaike's pick that they have."""
    t, f = computed
    front, zero, traces, truth = sonopack.front(t, f), 20 * random.random(), [], []
    times = np.arange(500) * 0.05 - 4.0 + random.random() * 0.05
    for distance in (0.5, 1.0, 1.5, 2.0):
        late = distance / SPEED * 1e3 - zero
        clean = np.interp(times - 2 - distance / SPEED * 1e3, t, f, left=0)
        size = noise * front.amplitude
        traces.append(Trace("lab", f"{distance}", times - zero, 0.7 + clean + size * random.normal(size=len(times)), distance=distance))
        peak = 2 + front.t_peak + late + zero
        truth.append((2 + front.t10 + late, expected_pick(times, clean[times < peak], size) - zero, math.nan, peak - zero))
    return traces, np.array(truth)


def expected_pick(times, clean, size):
    """Akaike's pick where noise adds exactly its variance."""
    k = np.arange(4, len(clean) - 4)
    value = [j * math.log(clean[:j].var() + size**2) + (len(clean) - j) * math.log(clean[j:].var() + size**2) for j in k]
    return times[k[int(np.argmin(value))]]


def inside(computed, noise, cases, highest=0.0):
    """The share of arrivals within two errors, and of speeds, by way. Noise of 10 % may hide t10.
    highest: of a filter [1/us], after which only speeds are what they were."""
    random = np.random.default_rng([SEED, int(1000 * noise)])
    off, speeds = [], []
    for _ in range(cases):
        traces, truth = case(computed, noise, random)
        for trace in traces if highest else ():
            trace.f = command._filtered(trace, (-math.inf, highest), 1.0)
        found = arrivals(traces)
        off += [(one.times - true) / one.errors for one, true in zip(found, truth)]
        distance = np.array([trace.distance for trace in traces])
        lines = [line(distance, found, k, distance[0] if k == 2 else math.nan) for k in range(4)]
        speeds.append([(fit.speed * 1e3 - SPEED) / (fit.error * 1e3) if fit else math.nan for fit in lines])
    share = [[float(np.mean(np.abs(each[np.isfinite(each)]) < 2)) if np.isfinite(each).any() else 1.0
              for each in np.array(rows).T] for rows in (off, speeds)]
    lost = np.mean(np.isnan(np.array(off)[:, 0]))
    print("seed", SEED, "noise", noise, dict(zip(WAYS, zip(*share))), "without t10", lost)
    assert lost == 0 or noise > 0.05
    return np.array(share[1:] if highest else share)


@pytest.mark.parametrize("noise", (0.01, 0.1))
def test_laboratory(computed, noise):
    """Of 24 arrivals within two errors (95 %) at least 20, of 6 speeds at least 5, but in one of a thousand cases."""
    arrived, speeds = inside(computed, noise, 6)
    assert np.all(arrived > 0.8) and np.all(speeds > 0.8)


def test_step():
    """The signal of a pulse generator, a step of a few samples with a noisy top: its edge is where it is, for any noise."""
    random, t = np.random.default_rng(SEED), np.arange(3000) * 0.1 - 50
    for noise, long in ((0.002, 0.1), (0.002, 1.0), (0.01, 0.5), (0.03, 2.0)):
        f = 5 * np.clip((t - 0.03) / long, 0, 1) + 5 * noise * random.normal(size=len(t)) + 0.7
        one, = arrivals([Trace("lab", "sync", t, f)])
        assert abs(one.times[0] - 0.03 - 0.1 * long) < 3 * one.errors[0] + 0.05 and one.errors[0] < 0.04 + noise * 3 * long, (noise, one.times[0], one.errors[0])


# ---- transfer functions ---------------------------------------------------------------------------------------------

def loss_pair(noise=0.0, q=30.0, way=20):
    """Two traces of a lattice whose springs have the loss factor 1 / q: sin(k / 2) = (omega / 2)(1 + i / (2 q)), in units of sites
    and sqrt(m / K); and its speed."""
    n, random = 2048, np.random.default_rng(SEED)
    t = np.arange(n) * 1.0
    omega = 2 * np.pi * np.fft.rfftfreq(n, 1.0)
    pulse = np.fft.rfft(np.exp(-((t - 300) / 12) ** 2 / 2) * np.sin((t - 300) / 9)) * (omega < 1.5)
    k = 2 * np.arcsin(np.minimum(omega, 1.5) / 2 * (1 + 0.5j / q))
    pair = [Trace("lattice", str(x), t - 7, 0.1 * x + np.fft.irfft(pulse * np.exp(-1j * k.conj() * x), n)
                  + noise * random.normal(size=n), distance=x) for x in (10.0, 10.0 + way)]
    return *pair, lambda w: w / (2 * np.arcsin(w / 2 * (1 + 0.5j / q))).real


def test_loss_and_speed():
    """1 / Q within 1 % (where the lattice's own loss exceeds 1 / q by no more), and speeds; with noise within their errors."""
    a, b, speed = loss_pair()
    ratio = transfer(a, b, (0, 0.25 / (2 * np.pi)))
    omega = 2 * np.pi * ratio.columns["frequency"]
    assert ratio.q_inverse == pytest.approx(1 / 30, rel=0.01) and not ratio.notes
    assert np.allclose(ratio.columns["speed"], speed(omega), rtol=1e-6)
    assert np.allclose(ratio.columns["group"], 1 / np.gradient(omega / speed(omega), omega, edge_order=2), rtol=1e-6)
    assert np.all(ratio.columns["coherence"] > 0.95)
    a, b, speed = loss_pair(0.003)
    ratio = transfer(a, b, (0, 0.25 / (2 * np.pi)))
    off = (ratio.columns["speed"] - speed(2 * np.pi * ratio.columns["frequency"])) / ratio.columns["speed_err"]
    assert np.mean(np.abs(off) < 2) > 0.85 and abs(ratio.q_inverse - 1 / 30) < 3 * ratio.q_inverse_err < 0.02
    with pytest.raises(Failed, match="noise"):
        transfer(*loss_pair(3.0)[:2])


def test_speed_of_a_chain():
    """Between planes of a computed chain: omega = 2 sqrt(k / m) sin(q a / 2), k = sqrt(overlap) / 2 of Hertz, m = pi / 6."""
    packing = sonopack.Packing.make(sonopack.Scene(packing={"kind": "chain", "grains": 300, "pressure": 1e-4}))
    height = packing.height
    step = np.diff(np.sort(packing.x[:, np.ptp(packing.x, axis=0).argmax()]))[150]
    signal = packing.network().signal(until=1400, points=2801, pulse=sonopack.Pulse.gauss(12), detectors=[
        f"plane:{100 * step:.17g}", f"plane:{130 * step:.17g}"])
    a, b = (Trace("chain", str(j), signal.t, signal.f[0, j], "own", distance=(100 + 30 * j) * step) for j in (0, 1))
    assert height > 290
    ratio = transfer(a, b, (0, 0.02))
    omega = 2 * np.pi * ratio.columns["frequency"]
    q = 2 / step * np.arcsin(omega / 2 / np.sqrt(0.5 * np.sqrt(1 - step) / (np.pi / 6)))
    assert len(omega) > 10 and np.allclose(ratio.columns["speed"], omega / q, rtol=1e-3) and abs(ratio.q_inverse) < 1e-3


# ---- computed signals -----------------------------------------------------------------------------------------------

def test_scale(computed):
    """A signal at 1.07 times its time scale, 3 us late: scale and pulse are found within three errors of up to 2 %, and E* by the
    command."""
    t, f = computed
    random = np.random.default_rng(SEED)
    times = np.arange(500) * 0.03
    clean = 0.4 * np.interp((times - 3) / 1.07, t, f, left=0)
    measured = Trace("lab", "a", times, clean + 0.01 * clean.max() * random.normal(size=len(times)))
    fit = against(measured, Trace("own", "F", t, f, "own"), free=True)
    assert abs(fit.scale - 1.07) < 3 * fit.scale_err < 0.06 and abs(fit.start - 3) < 3 * fit.start_err
    measured.t = measured.t - 3
    fit = against(measured, Trace("own", "F", t, f, "own"))
    assert abs(fit.scale - 1.07) < 3 * fit.scale_err < 0.01 and fit.amplitude == pytest.approx(0.4, rel=0.02) and fit.rms < 1.3


@pytest.mark.parametrize("f0, q", ((0.15, 3.0), (0.6, 1.0)))
def test_response(computed, f0, q):
    """A signal behind a resonance, convolved on a tenfold grid with omega/b exp(-omega t / (2 Q)) sin(b omega t): its scale is found
    with the resonance, and with the pulse that it makes of a delta, measured from 2 us before with another interval; not without."""
    t, f = computed
    random, fine, omega = np.random.default_rng(SEED), np.arange(6000) * 0.003, 2 * np.pi * f0
    b = math.sqrt(1 - 0.25 / q**2)

    def ringing(t):
        return np.where(t > 0, omega / b * np.exp(-omega * t / (2 * q)) * np.sin(b * omega * t), 0.0)

    clean = np.convolve(np.interp((fine - 4) / 1.07, t, f, left=0), ringing(fine))[:6000:10] * 0.003
    times = fine[::10] - 4
    measured = Trace("lab", "a", times, clean + 0.002 * clean.max() * random.normal(size=len(times)))
    long = np.arange(-2, 12 * q / omega, 0.021)
    pulse = Trace("lab", "pulse", long, 3 * ringing(long) + 1e-4 * random.normal(size=len(long)))
    signal = Trace("own", "F", t, f, "own")
    for response in Response((f0, q)), Response(pulse):
        fit = against(measured, signal, response=response)
        assert abs(fit.scale - 1.07) < 3 * fit.scale_err < 0.002 and fit.rms < 1.5, (fit.scale, fit.scale_err, fit.rms)
    assert fit.amplitude == pytest.approx(1 / 3, rel=0.02)
    bare = against(measured, signal)
    assert abs(bare.scale - 1.07) > 0.02 and bare.rms > 2 * fit.rms, (bare.scale, bare.rms)


# ---- files ----------------------------------------------------------------------------------------------------------

N = 400
T = np.round((np.arange(N) - 80) * 4e-7, 10)
A = np.round(np.exp(-((T - 4e-5) / 9e-6) ** 2 / 2) + 0.01 * np.sin(np.arange(N) ** 2), 5)
B = np.round(0.3 * np.roll(A, 60), 5)


def rows(form, *columns):
    return "".join(form.format(*row) for row in zip(*columns))


TEK = ["Record Length,4e2,", "Sample Interval,4e-07,", "Source,CH1,", "Vertical Units,V,", "Horizontal Units,s,"]
INFINIIUM = ("Revision:,0\nType:,raw\nStart:,0\nPoints:,400\nXDispOrg:,-3.2e-05\nXInc:,4e-07\nXOrg:,-3.2e-05\nXUnits:,Second\nYInc:,1e-5\n"
             "YUnits:,Volt\nMin Bandwidth:,0\nData:,\n")
FILES = {  # name: text, channels
    "tds.csv": ("".join(f"{TEK[k] if k < len(TEK) else ',,'},{T[k]:018.12f},{A[k]: 11.5f},\n" for k in range(N)), ["CH1"]),
    "mso.csv": ("Model,MSO4034\nHorizontal Units,S,\nSample Interval,4e-07,\nVertical Units,V,V\n,,\nTIME,CH1,CH2\n"
                + rows("{:.7e},{},{}\n", T, A, B), ["CH1", "CH2"]),
    "rigol.csv": ("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-3.2e-05,4.0e-07\n" + rows("{},{},{},\n", range(N), A, B),
                  ["CH1", "CH2"]),
    "rigol2.csv": ("Time(s),CH1(V),CH2(V),t0 = -3.2e-05, tInc = 4e-07,\n" + rows("{:.2e},{},{},,\n", T, A, B), ["CH1", "CH2"]),
    "keysight.csv": ("x-axis,1,2\nsecond,Volt,Volt\n" + rows("{:+.7E},{:+.6E},{:+.6E}\n", T, A, B), ["1", "2"]),
    "lecroy.csv": ("LECROYWR64Xi,31234,Waveform\nSegments,1,SegmentSize,400\nSegment,TrigTime,TimeSinceSegment1\n"
                   "#1,13-May-2011 11:12:13,0\nTime,Ampl\n" + rows("{:.9g},{}\n", T, A), ["Ampl"]),
    "mdo.csv": ("Model,MDO3014\nFirmware Version,1.20\n\nWaveform Type,ANALOG,,Waveform Type,DIGITAL,\nPoint Format,Y,,Point Format,Y,\n"
                "Horizontal Units,s,,Horizontal Units,s,\nSample Interval,4e-07,,Sample Interval,4e-07,\nRecord Length,400,,Record Length,"
                "400,\nGating,0.0% to 100.0%,,Gating,0.0% to 100.0%,\nVertical Units,V,,Vertical Units,V,\n\n\nTIME,CH1,,TIME,D1\n"
                + rows("{:.6e},{},,{:.6e},0\n", T, A, T), ["CH1"]),  # the digital channel is idle
    "mso58.csv": ("Model,MSO58\nFirmware Version,2.0.3\n\nWaveform Type,ANALOG,ANALOG\nHorizontal Units,s,s\nSample Interval,4e-07,4e-07\n"
                  "Zero Index,80,80\nVertical Units,V,V\nLabel,,\n,,\nTIME,CH1,CH2,\n" + rows("{:.9e},{},{},\n", T, A, B), ["CH1", "CH2"]),
    "ds1102e.csv": ("Time,X(CH1),X(CH2),\nSecond,Volt,Volt,\n" + rows("{:.8e},{:.5e},{:.5e},\n", T, A, B), ["CH1", "CH2"]),
    "siglent.csv": ("Record Length,Analog:400\nSample Interval,4e-07\nVertical Units,CH1:V,CH2:V\nHorizontal Units,s\nModel Number,SDS1204X-E\n"
                    "Source,CH1,CH2\nSecond,Volt,Volt\n" + rows("{:.9f},{},{}\n", T, A, B), ["CH1", "CH2"]),
    "infiniium.csv": (INFINIIUM + rows("{:.8E},{:.6E}\n", T, A), ["c2"]), "infiniium_y.csv": (INFINIIUM + rows("{:.6E}\n", A), ["c1"]),
    "lecroy.txt": ("LECROYHDO4054;31234;Waveform\nSegments;1;SegmentSize;400\nSegment;TrigTime;TimeSinceSegment1\n"
                   "#1;13-May-2011 11:12:13;0\nTime;Ampl\n" + rows("{:.9f};{:.6f}\n", T, A).replace(".", ","), ["Ampl"]),
    "pico_ms.csv": ("Time;Channel A;Channel B\n(ms);(mV);(mV)\n\n"
                    + rows("{:.8f};{:.5f};{:.5f}\n", T * 1e3, A * 1e3, B * 1e3).replace(".", ","), ["Channel A", "Channel B"]),
    "pico.csv": ("Zeit;Kanal A;Kanal B\n(µs);(V);(mV)\n\n" + rows("{:.8f};{:.5f};{:.5f}\n", T * 1e6, A, B * 1e3).replace(".", ","),
                 ["Kanal A", "Kanal B"]),
    "din.csv": ("t / µs\tU/V\n" + rows("{:.8f}\t{:.5f}\n", T * 1e6, A).replace(".", ","), ["U/V"]),
    "hantek.tsv": ("nr\ttime(s)\tch1\tch2\n" + rows("{}\t{:.7f}\t{}\t{}\n", range(N), T, A, B), ["ch1", "ch2"]),
    "plain.txt": (rows("{:.2f} {} {}\n", T * 1e6, A, B).replace(".", ","), ["c2", "c3"])}


@pytest.mark.parametrize("name", FILES)
def test_text(tmp_path, name):
    """Times in us and values as written: of 7 digits here, of times rounded to 3."""
    (tmp_path / name).write_text(FILES[name][0], encoding="latin-1")
    found = read(str(tmp_path / name), Form(time_unit="us") if name == "plain.txt" else Form())
    assert [trace.channel for trace in found] == FILES[name][1]
    for trace, values in zip(found, (A, B)):
        assert np.allclose(trace.t, T[0] * 1e6 + 0.4 * np.arange(N), atol=0.01) and np.allclose(trace.f, values, atol=1e-6)
        assert not trace.notes or "rounded" in trace.notes[0]
        assert trace.f_unit == "V" or not re.search("V", FILES[name][0][:-9000])


def sac_text(values):
    """Lines of 5 numbers, 5 integers and 24 letters, and the values."""
    numbers, integers, letters = [-12345.0] * 70, [-12345] * 40, ["-12345  "] * 24
    numbers[0], numbers[5], letters[20] = 4e-7, T[0], "BHZ     "
    for place, value in ((6, 6), (9, N), (15, 1), (35, 1)):
        integers[place] = value
    parts = ((numbers, "{:15.7G}", 5), (integers, "{:10d}", 5), (letters, "{}", 3), (values, "{:15.7G}", 5))
    return "".join("".join(map(form.format, part[k:k + n])) + "\n" for part, form, n in parts for k in range(0, len(part), n))


def test_binary(tmp_path, sonopack):
    """WAV of two channels; SAC of either order of bytes; a signal of our own as SAC and as a table."""
    import scipy.io.wavfile
    scipy.io.wavfile.write(tmp_path / "a.wav", 2500000, np.round(20000 * np.array([A, B])).astype(np.int16).T)
    found = read(str(tmp_path / "a.wav"))
    assert np.allclose([trace.f for trace in found], np.array([A, B]) * 20000 / 32768, atol=1e-4) and found[0].step == 0.4
    for order in "<>":
        numbers, integers = np.full(70, -12345.0), np.full(40, -12345)
        numbers[[0, 5]], integers[[6, 9, 15, 35]] = (4e-7, T[0]), (6, N, 1, 1)
        (tmp_path / "a.sac").write_bytes(struct.pack(f"{order}70f40i192s{N}f", *numbers, *integers, b"-12345  " * 24, *A))
        found = read(str(tmp_path / "a.sac"))
        assert np.allclose(found[0].t, T * 1e6, atol=1e-4) and np.allclose(found[0].f, A, atol=1e-6)
    (tmp_path / "text.sac").write_text(sac_text(A))
    for form in Form(), Form(kind="sac"):
        found = read(str(tmp_path / "text.sac"), form)
        assert np.allclose(found[0].t, T * 1e6, atol=1e-4) and np.array_equal(found[0].f, A) and found[0].channel == "BHZ"
    for text, said in ((sac_text(A[:-1]), "399 are there"), (sac_text(A).replace(" 4E-07", "-4E-07", 1), "equal intervals"),
                       (sac_text(A).replace("0.01", "O.01"), "O.01"), (sac_text(A)[:900], "header"), ("1 2\n" * 50, "header")):
        (tmp_path / "cut.sac").write_text(text)
        with pytest.raises(Failed, match=re.escape(said)):
            read(str(tmp_path / "cut.sac"), Form(kind="sac"))
    sonopack("chain", "signal", "--grains=20", "--points=500", "-o", "own.sac")
    sonopack("chain", "signal", "--grains=20", "--points=500", "-o", "own.tsv")
    one, other = (read(str(tmp_path / name))[0] for name in ("own-F.sac", "own.tsv"))
    assert np.allclose(one.f, other.f, atol=1e-6) and np.allclose(one.t, other.t, rtol=1e-6)


GLASS = "E=7e10,nu=0.2,rho=2500,d=1e-3"
WRONG = {"t,F\n" + "0,1\n" * 50: "must rise", "1.5,2\n" * 9: "9 lines", "word\n" * 50: "no columns of numbers",
         "t;F\n" + "".join(f"{k};{k % 7},5\n" for k in range(50)).replace("30;", "30;x"): ':32: "30;x2,5": must be numbers',
         "t,F\n" + "".join(f"{k * k},1\n" for k in range(50)): "intervals away", "\n".join("1 2 3 1 2".split() * 10): "--step",
         "t,F\n" + "".join(f"{k},{'' if k == 9 else k % 5}\n" for k in range(50)): "1 of 50 values are missing",
         "0,001,0,5\n" * 40: "commas stand between", "x" * 20 + "\0": "binary",
         "t (h),F\n" + "".join(f"{k},{k % 5}\n" for k in range(50)): "the unit of time is h"}


@pytest.mark.parametrize("text", WRONG)
def test_refusals(tmp_path, text):
    (tmp_path / "wrong.csv").write_text(text)
    with pytest.raises(Failed, match=re.escape(WRONG[text])):
        read(str(tmp_path / "wrong.csv"))


def test_command(tmp_path, sonopack):
    """Columns of the table, notes on what is doubtful, the prepared traces for front and plot, exit statuses."""
    (tmp_path / "s.csv").write_text("Time,CH1,CH2\n" + rows("{:.7e},{},{}\n", T, np.minimum(A, 0.9), B))
    done = sonopack("trace", "s.csv", "--distance", "0,6mm", "--trigger", "CH1", "--filter", ":600kHz", "--write", "w.tsv", "-o", "o.tsv")
    for text in ("no unit of time: seconds", "s.csv:CH1: clipped", "the pulse is at "):
        assert text in done.stderr
    table = Table.read(tmp_path / "o.tsv")
    assert table.names == ["file", "channel", "distance", "noise", *(f"{way}{end}" for way in WAYS for end in ("", "_err")), "amplitude",
                           "amplitude_err"]
    assert abs(table["t10"][0]) < 1e-9 and table["t_xcorr"][1] == pytest.approx(24, abs=0.5)
    assert table.number("speed_xcorr") == pytest.approx(250, rel=0.02) and table.units["t10"] == "us"
    assert "w.tsv:F2\t6\t" in sonopack("front", "w.tsv").stdout
    ratio = sonopack("trace", "s.csv", "--columns", "t=1,F=CH1,F=3", "--transfer", "1:2", "-q").stdout
    assert re.search("^frequency\tgain\tgain_err\tphase\tphase_err\tspeed\t", ratio, re.M) and "# 1/Q = " in ratio
    sonopack("chain", "signal", "--grains=20", "--pressure=1e-4", "--until=500", "-o", "c.tsv")
    own = Table.read(tmp_path / "c.tsv")
    Table.from_columns({name: own[name] for name in ("t", "F")}, {"t": own.units["t"]}).save(tmp_path / "one.tsv")
    (tmp_path / "m.csv").write_text("t(us),F(N)\n" + rows("{},{}\n", own["t"] * 0.2 + 10, own["F"] + 1e-9 * np.sin(np.arange(own.rows) ** 2)))
    sonopack("trace", "m.csv", "--trigger", "10us", "--against", "one.tsv", "--material", GLASS, "-o", "fit.tsv", "-q")
    assert Table.read(tmp_path / "fit.tsv").number("E*") == pytest.approx(2500 * (1e-3 / 0.2e-6) ** 2, rel=1e-3)
    (tmp_path / "ab.csv").write_text("t(us),A,B\n" + rows("{},{},{}\n", T * 1e6, A, B))
    assert [trace.channel for trace in read(str(tmp_path / "ab.csv"))] == ["A", "B"]
    k = np.arange(400)
    (tmp_path / "sign.csv").write_text("t(us),F\n" + rows("{},{}\n", k, np.exp(-((k - 200) / 20) ** 2) - 0.6 * np.exp(-((k - 260) / 20) ** 2)))
    for column, told in (("F=2", False), ("F=-2", True)):
        assert ("F=-" in sonopack("trace", "sign.csv", "--columns", f"t=1,{column}", "-o", f"{column}.tsv").stderr) == told
    for words in (["--distance", "1"], ["--pulse", "CH3"], ["--window", "3:1"], ["--band", "1:2"], ["--filter", "1:9MHz"],
                  ["--columns", "x=1"], ["--set", "a=1"], ["--units", "si"]):
        assert sonopack("trace", "s.csv", *words, status=2).stderr.startswith("sonopack: ")
    assert "no column CH9" in sonopack("trace", "s.csv", "--columns", "F=CH9", status=1).stderr
