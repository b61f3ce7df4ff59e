#!/usr/bin/env python3
"""No shader may turn what it fetches from a buffer into double at once: fetched_doubles.py FOLDER of *.spv files

NVIDIA's compiler (driver 580.159, H100) makes other numbers of OpImageFetch whose result OpFConvert takes to 64 bits
without a variable between (all images of the double kernels were black); lavapipe does not. --self-test tries the
check on made-up modules."""
import re
import subprocess
import sys
from pathlib import Path

# What hands a fetched value on without a variable.
PASSES_ON = ("OpCompositeExtract", "OpVectorShuffle", "OpCompositeConstruct", "OpCopyObject")


def fetched_doubles(text):
    """The ids of a disassembled module that are a fetch made double at once."""
    wide, fetched, found = set(), set(), []
    for line in text.splitlines():
        m = re.match(r"\s*(%\S+) = (Op\w+)\s*(.*)", line)
        if not m:
            continue
        result, op, words = m.group(1), m.group(2), m.group(3).split()
        if op == "OpTypeFloat" and words[0] == "64":
            wide.add(result)
        elif op == "OpTypeVector" and words[0] in wide:
            wide.add(result)
        elif op == "OpImageFetch":
            fetched.add(result)
        elif op in PASSES_ON and any(word in fetched for word in words[1:]):
            fetched.add(result)
        elif op == "OpFConvert" and words[0] in wide and words[1] in fetched:
            found.append(result)
    return found


def self_test():
    head = "%f = OpTypeFloat 32\n%d = OpTypeFloat 64\n%v = OpTypeVector %f 4\n%w = OpTypeVector %d 3\n%t = OpImageFetch %v %b %i\n"
    assert fetched_doubles(head + "%c = OpFConvert %w %t") == ["%c"]
    assert fetched_doubles(head + "%s = OpVectorShuffle %v %t %t 0 1 2\n%c = OpFConvert %w %s") == ["%c"]
    assert not fetched_doubles(head + "OpStore %x %t\n%l = OpLoad %v %x\n%c = OpFConvert %w %l")
    assert not fetched_doubles(head + "%c = OpFConvert %v %t")
    print("fetched_doubles.py: self-test passed")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    modules = sorted(Path(sys.argv[1]).glob("*precise*.spv"))
    if not modules:
        sys.exit(f"fetched_doubles.py: {sys.argv[1]} holds no *precise*.spv")
    bad = []
    for module in modules:
        text = subprocess.run(["spirv-dis", "--no-color", module], stdout=subprocess.PIPE, text=True, check=True).stdout
        bad += [f"{module.name}: {found}" for found in fetched_doubles(text)]
    if bad:
        sys.exit("fetched_doubles.py: a fetch is converted to double at once (put it into a variable first):\n  " + "\n  ".join(bad))
    print(f"fetched_doubles.py: {len(modules)} modules, no fetch is converted to double at once")
    return 0


if __name__ == "__main__":
    sys.exit(main())
