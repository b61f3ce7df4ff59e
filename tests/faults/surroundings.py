# SPDX-License-Identifier: Apache-2.0
"""What the machine may do to a command: helpers that are missing, hang or lie, processes killed, no files or memory to be
had, another locale, a clock that goes back, two programs at once."""
import contextlib
import errno
import os
import resource
import shutil
import signal
import sqlite3
import subprocess
import time

import running
import tree
import writes

REFUSALS = (2, 3, 4)
NO_MEMORY = 3
HELPERS = {
    "fails": "exit 3",
    "rubbish": "head -c 5000 /dev/urandom",
    "only the end of a drawing": "echo '</svg>'; echo '<svg'",
    "without end": "exec yes '<svg"+">'",
    "dies": "kill -SEGV $$",
}


def helper(suite, names, script):
    """A folder for PATH, with these commands alone; None: without them."""
    folder = os.path.join(suite.folder, "bin")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in names if script is not None else ():
        path = os.path.join(folder, name)
        with open(path, "w", encoding="ascii") as file:
            file.write("#!/bin/sh\nPATH=/usr/bin:/bin\n" + script + "\n")
        os.chmod(path, 0o755)
    return folder


def whole(suite, command, out, run, codes=(0,), old=None):
    """The faults of a run that has to give whole results, or to refuse in one sentence."""
    faults = suite.references[command.name].faults(command, out, run.code, old=old)
    if run.code not in codes:
        faults.append(f"exit code {run.code}: {run.err[-300:]}")
    if run.code == 0 and command.same_words and run.out != suite.printed[command.name]:
        faults.append("it prints other words: " + run.out[-300:])
    if run.code != 0 and running.sentences(run) != 1:
        faults.append("no sentence about it: " + run.err[-300:])
    return faults


def told(where, faults):
    return [f"{where}: {fault}" for fault in faults]


def some(suite, everything, cases, most):
    """All of the cases, or a few of them."""
    cases = list(cases)
    return cases if everything else suite.random.sample(cases, min(most, len(cases)))


def gnuplot(suite, everything):
    command = suite.commands["compare"]
    for name, script in some(suite, everything, [("missing", None), *HELPERS.items()], 2):
        out = suite.fresh_folder()
        run = suite.run(command, out, {"PATH": helper(suite, ["gnuplot"], script)})
        faults = whole(suite, command, out, run)
        page = os.path.join(out, "report.html")
        if run.code == 0 and "Plot left out" not in open(page, encoding="utf-8").read():
            faults.append("the page does not say that its plots are left out")
        suite.report("surroundings", told(f"gnuplot {name}", faults))
    out = suite.fresh_folder()
    process = suite.start(command.line(suite.program, out), {"PATH": helper(suite, ["gnuplot"], "exec sleep 1000")})
    time.sleep(2 * suite.seconds["compare"] + 0.5)
    process.send_signal(signal.SIGTERM)
    run = suite.finish(process)
    faults = suite.references["compare"].faults(command, out, run.code)
    if run.seconds > 2.0 or run.code != 130:
        faults.append(f"ended after {run.seconds:.1f} s with exit code {run.code}")
    suite.report("surroundings", told("gnuplot hangs, SIGTERM", faults))
    if everything:
        out = suite.fresh_folder()
        run = suite.run(command, out, {"PATH": helper(suite, ["gnuplot"], "exec sleep 1000")})
        suite.report("surroundings", told("gnuplot hangs", whole(suite, command, out, run)))


def slurm(suite, everything):
    command = suite.commands["study"]
    line = command.line(suite.program, "{out}") + ["--engine", "slurm"]
    scripts = [("missing", None), *HELPERS.items(),
               ("submits rubbish", 'case $0 in *sbatch) test "$1" = --version || echo "no number";; esac'),
               ("hangs", ": >'{asked}'; exec sleep 1000")]
    for name, script in some(suite, everything, scripts, 3):
        out = suite.fresh_folder()
        asked = os.path.join(suite.folder, "asked")
        path = helper(suite, ["sbatch", "squeue", "scancel"], script and script.replace("{asked}", asked))
        process = suite.start([w.replace("{out}", out) for w in line], {"PATH": path})
        if name == "hangs":
            running.until(process, lambda: os.path.exists(asked))
            process.send_signal(signal.SIGINT)
        run = suite.finish(process, 60)
        faults = suite.references["study"].faults(command, out, run.code)
        if run.code not in ((130,) if name == "hangs" else REFUSALS):
            faults.append(f"exit code {run.code}: {run.err[-300:]}")
        if len(run.err) > 2000 or "\x1b" in run.err:
            faults.append("says too much: " + repr(run.err[:200]))
        suite.report("surroundings", told(f"Slurm's commands: {name}", faults))


def children(process):
    found = []
    with contextlib.suppress(OSError):  # it has ended
        for task in os.listdir(f"/proc/{process.pid}/task"):
            with open(f"/proc/{process.pid}/task/{task}/children", encoding="ascii") as file:
                found += [int(word) for word in file.read().split()]
    return found


def has_open(process, path):
    folder = f"/proc/{process.pid}/fd"
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            with contextlib.suppress(OSError):
                if os.readlink(os.path.join(folder, name)) == path:
                    return True
    return False


def workers(suite, everything):
    """Every worker killed, three times over: the study comes to its end, and counts what it lost."""
    out, killed = suite.fresh_folder(), 0
    process = suite.start([suite.program, "study", suite.rig.path("LONG.toml"), "--out", out, "--jobs", "2"])
    for _ in range(3):
        running.until(process, lambda: children(process))
        time.sleep(0.3)
        for pid in children(process):
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.kill(pid, signal.SIGKILL)
                killed += 1
    run = suite.finish(process)
    # 4: it gave up on workers that died before they had begun; what is finished is kept
    faults = [] if run.code in (0, 4) else [f"exit code {run.code}: {run.err[-300:]}"]
    if killed == 0:
        faults.append("no worker was there to be killed")
    run = suite.finish(suite.start([suite.program, "study", suite.rig.path("LONG.toml"), "--out", out]))
    faults += [] if run.code == 0 else [f"run again: exit code {run.code}: {run.err[-300:]}"]
    table = os.path.join(out, "study.csv")
    rows = open(table, encoding="ascii").read().count("\n") - 1 if os.path.exists(table) else 0
    if rows != 200:
        faults.append(f"{rows} of 200 rows in study.csv")
    suite.report("surroundings", told(f"{killed} workers killed", faults))


def two_programs(suite, everything):
    for name in some(suite, everything, ("cosim", "render", "study", "import", "capture"), 2):
        command, out = suite.commands[name], suite.fresh_folder()
        both = [suite.start(command.line(suite.program, out)) for _ in range(2)]
        runs = [suite.finish(process) for process in both]
        faults = []
        for run in runs:
            refused = name == "capture" and run.code == 2 and running.sentences(run) == 1
            faults += suite.references[name].faults(command, out, run.code)
            if run.code != 0 and not refused:
                faults.append(f"exit code {run.code}: {run.err[-300:]}")
        suite.report("surroundings", told(f"two of {name} in one folder", faults))


def locked_database(suite, everything):
    """Another program holds study.db: Ctrl-C is not kept waiting for it."""
    command, out = suite.commands["study"], suite.complete_folder(suite.commands["study"])
    file = os.path.join(out, "study.db")
    with sqlite3.connect(file, isolation_level=None) as database:
        database.execute("begin exclusive")
        process = suite.start(command.line(suite.program, out))
        running.until(process, lambda: has_open(process, file))
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        run = suite.finish(process)
        database.execute("rollback")
    faults = whole(suite, command, out, run, (130,))
    if run.seconds > 2.0:
        faults.append(f"took {run.seconds:.1f} s to end")
    suite.report("surroundings", told("a locked database, SIGINT", faults))


def without_home(suite, everything):
    command, out = suite.commands["cosim"], suite.fresh_folder()
    run = suite.run(command, out, {"HOME": None, "XDG_CACHE_HOME": None, "FRINGETWIN_CACHE": None})
    suite.report("surroundings", told("HOME unset", whole(suite, command, out, run)))


def comma_locale(suite, everything):
    """A locale that writes 1,5 for 1.5, made here."""
    place = os.path.join(suite.folder, "locale")
    os.makedirs(place, exist_ok=True)
    made = subprocess.run(["localedef", "--no-archive", "-i", "de_DE", "-f", "UTF-8", os.path.join(place, "de_DE.UTF-8")],
                          capture_output=True, check=False)
    if not os.path.exists(os.path.join(place, "de_DE.UTF-8", "LC_NUMERIC")):
        why = made.stderr.decode(errors="replace").strip()
        suite.report("surroundings", [f"no comma locale could be made (Debian: package locales): {why}"])
        return
    for name in suite.commands if everything else ("cosim", "calibrate"):
        command, out = suite.commands[name], suite.fresh_folder()
        run = suite.run(command, out, {"LOCPATH": place, "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"})
        suite.report("surroundings", told(f"{name} under a comma locale", whole(suite, command, out, run)))


def clock(suite, everything):
    for name in some(suite, everything, suite.commands, 2):
        command, out = suite.commands[name], suite.fresh_folder()
        run = suite.run(command, out, {"LD_PRELOAD": suite.faults, "FAULT_CLOCK": "3600"})
        suite.report("surroundings", told(f"{name}, the clock goes back", whole(suite, command, out, run)))


def read_only(suite, everything):
    """A folder below which nothing can be made or opened for writing: refused, and the results there are as they were."""
    for name in some(suite, everything, suite.commands, 3):
        command, out = suite.commands[name], suite.old_folder(suite.commands[name])
        old = tree.files(out)
        environment = writes.environment(suite, out, "open,write,mkdir,rename,remove", 1, errno.EROFS, True)
        run = suite.run(command, out, environment, again=True)
        writes_nothing = name == "capture" or not command.sign  # the first finds nothing left to do
        codes = REFUSALS + ((0,) if writes_nothing else ())
        faults = whole(suite, command, out, run, codes, old)
        if tree.files(out) != old:
            faults.append("the folder is not as it was")
        suite.report("surroundings", told(f"{name} into a read-only folder", faults))


def few_files(suite, everything):
    counts = some(suite, everything, range(3, 40), 2)
    for name in suite.commands if everything else ("cosim", "study"):
        for most in counts:
            command, out = suite.commands[name], suite.fresh_folder()
            run = suite.run(command, out, {},
                            preexec_fn=lambda most=most: resource.setrlimit(resource.RLIMIT_NOFILE, (most, most)))
            if run.code == 127:
                continue  # not even its libraries could be opened
            faults = whole(suite, command, out, run, (0, *REFUSALS))
            if "drawings could not be made" in run.err:
                faults = [fault for fault in faults if "figures/" not in fault]
            suite.report("surroundings", told(f"{name} with {most} files", faults))


def little_memory(suite, everything):
    sizes = some(suite, everything, range(300, 3000, 100), 3)
    for name in suite.commands if everything else ("measure", "cosim"):
        for megabytes in sizes:
            command, out, most = suite.commands[name], suite.fresh_folder(), megabytes << 20
            run = suite.run(command, out, {},
                            preexec_fn=lambda most=most: resource.setrlimit(resource.RLIMIT_AS, (most, most)))
            if run.code == 127:
                continue
            faults = whole(suite, command, out, run, (0, NO_MEMORY))
            if run.code != 0 and "not enough memory" not in run.err:
                faults.append("does not say that memory is short: " + run.err[-300:])
            suite.report("surroundings", told(f"{name} in {megabytes} MB", faults))


def streams(suite, everything):
    """Nobody listens: no stream at all, or a full device."""
    command, out = suite.commands["measure"], suite.fresh_folder()
    line = " ".join(f"'{word}'" for word in command.line(suite.program, out))
    run = suite.finish(suite.start(["/bin/sh", "-c", f"exec {line} <&- >&- 2>&-"]))
    suite.report("surroundings", told("closed streams", whole(suite, command, out, run)))
    result = os.path.join(suite.folder, "good", "measure", "result.json")
    for words in (["info"], ["--version"], ["--help"], ["diff", result, result]):
        run = suite.finish(suite.start(["/bin/sh", "-c", '"$@" >/dev/full', "sh", suite.program, *words]))
        faults = [] if run.code in REFUSALS and running.sentences(run) == 1 else [f"exit code {run.code} {run.err[-300:]}"]
        suite.report("surroundings", told(f"{words[0]} to a full device", faults))


PARTS = (gnuplot, slurm, workers, two_programs, locked_database, without_home, comma_locale, clock, read_only, few_files, little_memory, streams)


def check(suite, everything, only=""):
    for part in PARTS:
        if not only or part.__name__ == only:
            part(suite, everything)
