#!/usr/bin/env bash
# scripts/run_tests.sh BUILD [ctest options]: runs the tests and shows every skip with its reason.
set -uo pipefail
build=$1
shift
export UBSAN_OPTIONS=print_stacktrace=1
# Leak checking is off for what we do not own (drivers, PCL's static tables).
# What is freed is kept from use for a while: of 256 MiB, as it comes, the kernel has a third of the time of two threads.
export ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=32
# Tests run side by side: a thread that spins while it waits takes the core from another.
export OMP_WAIT_POLICY=${OMP_WAIT_POLICY:-passive}
# One more than there are cores: some wait for their workers, a virtual machine or another program.
ctest --test-dir "$build" --no-tests=error --output-on-failure -j "$(($(nproc) + 1))" --output-log "$build/ctest.log" "$@"
status=$?
# Every skipped case with its reason: the lines between "file:line: Skipped" and "[  SKIPPED ] name".
log=$build/Testing/Temporary/LastTest.log
if [ -f "$log" ]; then
  awk '/: Skipped$/ { reason = ""; open = 1; next }
       /^\[  SKIPPED \] .*ms\)$/ { if (open) print "skipped: " $4 ": " reason; open = 0; next }
       open && NF { reason = reason (reason == "" ? "" : " ") $0 }' "$log" | sort -u
fi
exit $status
