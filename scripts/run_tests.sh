#!/usr/bin/env bash
# scripts/run_tests.sh BUILD [ctest options]: runs the tests and shows every skip with its reason.
set -uo pipefail
build=$1
shift
export UBSAN_OPTIONS=print_stacktrace=1
# Leak checking is off for what we do not own (drivers, PCL's static tables).
export ASAN_OPTIONS=detect_leaks=0
ctest --test-dir "$build" --output-on-failure -j "$(nproc)" --output-log "$build/ctest.log" "$@"
status=$?
grep -h "SKIPPED:" "$build/Testing/Temporary/LastTest.log" 2>/dev/null | sort -u
exit $status
