#!/usr/bin/env bash
# scripts/demo.sh OUT CAPTURES: the main job on the paper's sphere and, where its images are, on a real capture.
set -uo pipefail
cd "$(dirname "$0")/.."
out=$1
captures=$2
export FRINGETWIN_CAPTURES=$captures

reports=()
run() { # NAME: a verdict "fail" (exit 1) is a result, not a broken demo
  build/fringetwin cosim "datasets/$1/twin.toml" --out "$out/$1"
  local status=$?
  if [ $status -gt 1 ]; then exit $status; fi
  reports+=("$out/$1/report.html")
}

run paper-sphere
if [ -d "$captures/slmaster-mono-relief" ]; then
  run slmaster-mono-relief
else
  echo "fringetwin: no real captures at $captures (FRINGETWIN_CAPTURES), so only the paper's sphere was run" >&2
fi

echo
echo "Reports (open in any browser, no network needed):"
for report in "${reports[@]}"; do
  echo "  file://$(realpath "$report")"
done
