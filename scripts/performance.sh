#!/usr/bin/env bash
# Measures the tables of docs/benchmarks on this machine and writes a page per twin, which says at which commit.
#   scripts/performance.sh [--quick] [--reuse]     twins: TWINS="paper-sphere ..." (default: the paper's three)
# PAGES is the folder of the pages (default docs/benchmarks).
# --quick: few schemes and pixels, for trying the script; --reuse: only make the tables of OUT again.
# Results stay in OUT (default out/performance): one folder per twin with its commit and date (measured_at), and in it
# one per command with JSON and page.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${OUT:-out/performance}
pages=${PAGES:-docs/benchmarks}
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
    echo "commit $(git describe --always --dirty), $(date +%F)" >"$out/$twin/measured_at"
  done
fi
mkdir -p "$pages"
python3 scripts/performance_tables.py "$out" "$pages" $twins
