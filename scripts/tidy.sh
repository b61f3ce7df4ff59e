#!/usr/bin/env bash
# scripts/tidy.sh BUILD FOLDER...: clang-tidy with the rules of .clang-tidy over our sources (no tests) in the
# folders, as BUILD/compile_commands.json compiles them. Fails on any finding.
set -uo pipefail
cd "$(dirname "$0")/.."
build=$1
shift
if ! command -v clang-tidy >/dev/null; then
  echo "tidy: clang-tidy is missing (packages.txt names it; run: make deps)" >&2
  exit 2
fi
mapfile -t files < <(git ls-files "${@/%/\/*.cpp}" | grep -v '_test\.cpp$')
if [ ${#files[@]} -eq 0 ]; then
  echo "tidy: no source in: $*" >&2
  exit 2
fi
# -Wno-unknown-warning-option: the flags are g++'s.
printf '%s\n' "${files[@]}" |
  xargs -P "$(nproc)" -n 4 clang-tidy -p "$build" --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option
status=$?
[ $status -eq 0 ] && echo "tidy: ${#files[@]} files as .clang-tidy says"
exit $status
