# SPDX-License-Identifier: Apache-2.0
"""Every call that changes the folder of results fails once, or for ever, or is the last of the process."""
import errno
import os
import random
import struct

import running
import tree

CALLS = ("open", "write", "rename", "remove", "mkdir", "sync", "close")  # as faults.cpp counts them
# call, error, whether it lasts
KINDS = [("write", errno.ENOSPC, True), ("write", errno.EIO, False), ("open", errno.EMFILE, False),
         ("open", errno.ENOSPC, True), ("mkdir", errno.ENOSPC, True), ("rename", errno.EIO, False),
         ("sync", errno.EIO, False), ("close", errno.EIO, False), ("rename", "kill", False)]


def environment(suite, out, calls, at, error, lasts):
    counter = os.path.join(suite.folder, "count")
    with open(counter, "wb") as file:
        file.write(bytes(64))
    found = {"LD_PRELOAD": suite.faults, "FAULT_BELOW": out, "FAULT_CALLS": calls, "FAULT_AT": str(at),
             "FAULT_ERROR": str(error), "FAULT_COUNT": counter}
    if lasts:
        found["FAULT_LASTS"] = "1"
    return found


def counted(suite):
    """How many calls counted, and how many of each kind there were."""
    with open(os.path.join(suite.folder, "count"), "rb") as file:
        first, *others = struct.unpack("8q", file.read(64))
    return first, dict(zip(CALLS, others))


def disturb(suite, command, kind, n, anew):
    """One fault at the n-th call; `anew`: in an empty folder, else over complete results. Returns sentences about faults, or
    None where the run had no n-th call."""
    calls, error, lasts = kind
    out = suite.fresh_folder() if anew else suite.old_folder(command)
    old = {} if anew else tree.files(out)
    run = suite.run(command, out, environment(suite, out, calls, n, error, lasts), again=not anew)
    if counted(suite)[0] < n:
        return None
    name = error if error == "kill" else errno.errorcode[error]
    where = f"{command.name}{'' if anew else ' over old results'}, {calls} {n} {name}{' lasting' if lasts else ''}"
    killed = error == "kill"
    faults = suite.references[command.name].faults(command, out, run.code, killed, old)
    if not killed and run.code not in (0, 2, 3, 4):
        faults.append(f"exit code {run.code}")
    if run.code != 0 and not killed and running.sentences(run) != 1:
        faults.append("no sentence about it")
    after = suite.run(command, out, {}, again=command.name == "capture" or os.path.exists(os.path.join(out, command.sign)))
    if after.code != 0:
        faults.append(f"run again: exit code {after.code}: {after.err[-300:]}")
    else:
        faults += ["run again: " + f for f in suite.references[command.name].faults(command, out, 0, killed)]
    return [f"{where}: {fault} [{run.err[-300:].strip()}]" for fault in faults]


def check(suite, everything, only=""):
    for command in [c for c in suite.commands.values() if only in ("", c.name)]:
        # Its own numbers: how many calls there are differs from run to run, and would change what all others draw.
        chance = random.Random(f"{suite.seed} {command.name}")
        cases = []
        for anew in (True, False) if everything else (chance.random() < 0.5,):
            out = suite.fresh_folder() if anew else suite.old_folder(command)
            suite.run(command, out, environment(suite, out, "", 0, 0, False), again=not anew)
            calls = counted(suite)[1]
            cases += [(kind, n, anew) for kind in KINDS for n in range(1, calls[kind[0]] + 1)]
        if not everything:
            cases = chance.sample(cases, min(1, len(cases)))  # none where a command only prints
        for kind, n, anew in cases:
            suite.report("writes", disturb(suite, command, kind, n, anew))
        if everything:
            print(f"writes of {command.name}: {len(cases)} disturbed", flush=True)
