#!/usr/bin/env bash
# Measures the tables of docs/PERFORMANCE.md on this machine and puts them between the file's markers.
#   scripts/performance.sh [--quick] [--reuse]     twins: TWINS="paper-sphere ..." (default: the paper's three)
# --quick: few schemes and pixels, for trying the script; --reuse: only make the tables of OUT again.
# Results stay in OUT (default out/performance): one folder per twin and command, with JSON and page.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${OUT:-out/performance}
twins=${TWINS:-"paper-sphere paper-ideal-plane paper-freeform"}
quick=() reuse=0
for arg in "$@"; do
  case "$arg" in
    --quick) quick=(--quick) ;;
    --reuse) reuse=1 ;;
    *) echo "performance.sh: unknown argument $arg" >&2; exit 2 ;;
  esac
done
if [ $reuse = 0 ]; then
  for twin in $twins; do
    build/fringetwin pareto "datasets/$twin/twin.toml" --out "$out/$twin/pareto" "${quick[@]}"
    build/fringetwin needs "datasets/$twin/twin.toml" --out "$out/$twin/needs"
  done
fi
python3 scripts/performance_tables.py "$out" docs/PERFORMANCE.md $twins
