#!/usr/bin/env bash
# The whole simulated measurement (2 cameras x 12 patterns at 1440 x 1080, decode and fit included), split per
# stage, against the published system's figures on its own GPU machine. Best of RUNS (default 3) runs.
set -euo pipefail
cd "$(dirname "$0")/.."
runs=${RUNS:-3}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for twin in paper-ideal-sphere paper-sphere paper-freeform; do
  for ((i = 0; i < runs; ++i)); do
    build/fringetwin -q cosim "datasets/$twin/twin.toml" --out "$scratch/$twin" 2>/dev/null || [ $? -eq 1 ]
    cp "$scratch/$twin/result.json" "$scratch/$twin.$i.json"
  done
done
python3 - "$scratch" "$runs" <<'PY'
import json, os, sys
scratch, runs = sys.argv[1], int(sys.argv[2])
published = {"paper-ideal-sphere": 2.2, "paper-freeform": 45.8}
bound = {"paper-ideal-sphere": 4.0, "paper-sphere": 4.0, "paper-freeform": 12.0}  # the project's own, s
stages = ["render", "decode_simulated", "match_simulated", "triangulate_simulated", "fit_simulated"]
print(f"whole simulated measurement, {os.cpu_count()} cores, best of {runs} runs (s)")
print(f"{'twin':20s} {'render':>8s} {'decode':>8s} {'match':>8s} {'triang.':>8s} {'fit':>8s} {'whole':>8s}"
      f" {'bound':>8s} {'of bound':>8s} {'published':>10s}")
for twin in ("paper-ideal-sphere", "paper-sphere", "paper-freeform"):
    best = None
    for i in range(runs):
        t = json.load(open(f"{scratch}/{twin}.{i}.json"))["timing_s"]
        whole = t["render"] + t["measure_simulated"]
        if best is None or whole < best[0]:
            best = (whole, [t.get(s, float("nan")) for s in stages])
    row = "".join(f" {v:8.3f}" for v in best[1])
    share = 100.0 * best[0] / bound[twin]
    print(f"{twin:20s}{row} {best[0]:8.3f} {bound[twin]:8.1f} {share:7.0f}% {published.get(twin, float('nan')):10.1f}")
print("published: IEEE Access 2023 (DOI 10.1109/ACCESS.2023.3306779), i7-10750H + Quadro P620, 1024 samples per pixel")
PY
