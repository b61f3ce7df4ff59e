# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM at random moments of every command: it ends soon, and leaves nothing half-written."""
import os
import signal
import time

LONGEST_S = 2.0
CANCELLED = 130


def interrupt(suite, command, number, after_s, cancelled):
    out = suite.fresh_folder()
    process = suite.start(command.line(suite.program, out))
    time.sleep(after_s)
    process.send_signal(number)
    run = suite.finish(process)
    where = f"{command.name}, {number.name} after {after_s:.3f} s"
    faults = suite.references[command.name].faults(command, out, run.code)
    if run.seconds > LONGEST_S:
        faults.append(f"took {run.seconds:.1f} s to end")
    cancelled[command.name] = cancelled.get(command.name, 0) + (run.code == CANCELLED)
    # 0: it had ended; -signal: it had not yet begun
    if run.code not in (0, CANCELLED, -number):
        faults.append(f"exit code {run.code}")
    if suite.random.random() < 0.2:
        after = suite.run(command, out, {}, again=os.path.exists(out) and os.listdir(out) != [])
        if after.code != 0:
            faults.append(f"run again: exit code {after.code}: {after.err[-300:]}")
        else:
            faults += ["run again: " + f for f in suite.references[command.name].faults(command, out, 0)]
    return [f"{where}: {fault} [{run.err[-300:].strip()}]" for fault in faults]


def check(suite, everything):
    commands, cancelled = list(suite.commands.values()), {}
    for moment in range(500 if everything else 20):
        command = commands[moment % len(commands)]
        number = suite.random.choice((signal.SIGINT, signal.SIGTERM))
        after_s = suite.random.uniform(0.0, 1.05 * suite.seconds[command.name])
        suite.report("signals", interrupt(suite, command, number, after_s, cancelled))
    # Who does not heed signals ends with 0. With 500 moments a command has 45, with 20 it may well have none in its time.
    long = [name for name in cancelled if suite.seconds[name] > 0.5]
    unheeded = [name for name in long if not cancelled[name]] if everything or not any(cancelled.values()) else []
    suite.report("signals", [f"{name}: no signal has ended it" for name in unheeded])
