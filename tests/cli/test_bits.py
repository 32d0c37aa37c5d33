"""No fused multiply-add in our own code: with it the bits of a packing would depend on the processor (gcc 12 forms
vfmaddsub in vectorized code even under -ffp-contract=off)."""
import re
import shutil
import subprocess
import sys

command = sys.argv[1]
if not shutil.which("objdump"):
    sys.exit(77)
fused = {}
where = None
for line in subprocess.run(["objdump", "-d", "--no-show-raw-insn", command], capture_output=True, text=True,
                           check=True).stdout.splitlines():
    head = re.match(r"[0-9a-f]+ <(.*)>:$", line)
    if head:
        where = head.group(1)
    elif re.search(r"\tv?f(n?m(add|sub)|maddsub|msubadd)", line) or re.search(r"\tvfn?m", line):
        fused.setdefault(where, line.split("\t")[-1])
assert where, "no code found"
assert not fused, f"fused operations: {fused}"
print("no fused operation")
