"""The commands that Python does (plot, convert, view, ...) without the second that each takes to load its modules: one
process loads them once, and does each command in a fork of itself, as it is written, in its own folder, environment and
files. That they also begin by themselves is seen where tests/package and tests/shows/plot/test_command.py call them.
"""
import atexit
import contextlib
import functools
import importlib
import io
import marshal
import os
import pathlib
import pkgutil
import runpy
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import traceback

# stands where the command looks for sonopack-NAME: hands itself over, and ends as the fork did
CALLER = """#!/usr/bin/python3 -SEB
import marshal, os, signal, socket, sys
server = socket.socket(socket.AF_UNIX)
server.connect({address!r})
call = marshal.dumps(({program!r}, sys.argv[1:], os.getcwd(), dict(os.environ)))
socket.send_fds(server, [len(call).to_bytes(8, "little")], [0, 1, 2])
server.sendall(call)
status = marshal.loads(server.recv(8))
if status < 0:
    signal.signal(-status, signal.SIG_DFL)
    os.kill(os.getpid(), -status)
sys.exit(status)
"""


@functools.cache
def warm(command):
    """A folder with a copy of the command, whose Python programs are begun already; gone when this process ends."""
    place = tempfile.TemporaryDirectory(prefix="sonopack-warm-")
    atexit.register(place.cleanup)
    command, folder = pathlib.Path(command), pathlib.Path(place.name)
    shutil.copy(command, folder / "sonopack")
    programs = [path for path in command.parent.glob("sonopack-*")
                if path.is_file() and path.open("rb").read(2) == b"#!"]
    address = str(folder / "socket")
    for path in programs:
        (folder / path.name).write_text(CALLER.format(address=address, program=str(path)))
        (folder / path.name).chmod(0o755)
    if programs:
        server = subprocess.Popen([sys.executable, "-B", __file__, address, command.parent / "python"], text=True,
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        atexit.register(server.communicate)  # the end of its input ends it
        assert server.stdout.readline() == "ready\n"
    return folder


def load(package):
    """All that any command may import, and what a first figure reads."""
    sys.path.insert(0, package)
    import sonopack
    modules = [found.name for found in pkgutil.walk_packages(sonopack.__path__, "sonopack.", onerror=lambda name: None)]
    for name in (*modules, "h5py", "pandas", "scipy.io", "matplotlib.backends.backend_svg",
                 "matplotlib.backends.backend_pdf"):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    with contextlib.suppress(ImportError):
        from matplotlib.figure import Figure
        figure = Figure()
        figure.text(0.5, 0.5, "$x^{1/2}$")
        figure.savefig(io.BytesIO(), format="png")


def status_of(program):
    """Runs a program to its end, and what it has left to be done then."""
    status = 0
    try:
        runpy.run_path(program, run_name="__main__")
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
        status = 1
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    return status


def take(client):
    """In a fork: reads a call, runs its program in a fork of its own, and answers how that ended."""
    length, files, _, _ = socket.recv_fds(client, 8, 3)
    program, words, folder, environment = marshal.loads(client.makefile("rb").read(int.from_bytes(length, "little")))
    child = os.fork()
    if child:
        client.sendall(marshal.dumps(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])))
        os._exit(0)
    client.close()
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    sys.stdin, sys.stdout, sys.stderr = open(0, closefd=False), open(1, "w", closefd=False), open(2, "w", closefd=False)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = [program, *words]
    os._exit(status_of(program))  # taking all modules down again would take longer than most commands


def serve(address, package):
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        load(package)
        print("ready", flush=True)
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for the forks that answer
        while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
            client, _ = listener.accept()
            if os.fork() == 0:
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                listener.close()
                take(client)
            client.close()


if __name__ == "__main__":
    serve(*sys.argv[1:])
