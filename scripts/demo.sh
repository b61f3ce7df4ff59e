#!/usr/bin/env bash
# demo.sh [OUT [CAPTURES]]: the main job on the paper's sphere, on images of another renderer with a twin that is
# right, one that is wrong and one that was mended, and, where its images are, on a real capture. OUT/index.html lists
# the reports.
# In a checkout it runs the program of build/, from the checkout; installed (share/fringetwin/demo.sh), the one installed.
set -uo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if [ -d "$here/datasets" ]; then
  program=$here/../../bin/fringetwin data=$here/datasets
else
  cd "$here/.." || exit 2
  program=build/fringetwin data=datasets
fi
out=${1:-fringetwin-demo}
captures=${2:-${FRINGETWIN_CAPTURES:-../shared/captures}}
export FRINGETWIN_CAPTURES=$captures
mkdir -p "$out" || exit 2

# FOLDER TWIN WHAT [option ...]: a verdict "fail" (exit 1) is a result, not a broken demo
run() {
  local folder=$1 twin=$2 what=$3
  shift 3
  echo "== $what"
  "$program" cosim "$data/$twin" --out "$out/$folder" "$@"
  local status=$?
  if [ $status -gt 1 ]; then exit $status; fi
}

run paper-sphere paper-sphere/twin.toml "the published rig and sphere, against the published numbers"
run foreign povray-ball-wall/twin.toml "images of another renderer (POV-Ray), with sensor noise; the twin's gain is 5 % too large, and the true one is found"
run foreign-moved povray-ball-wall/twin-moved.toml "the same images, a twin with the ball 0.12 mm elsewhere: not explained, and the cause is named"
run foreign-refined povray-ball-wall/twin-moved.toml "that twin after --refine pose: the ball is where it was, everything is explained" --refine pose
if [ -d "$captures/slmaster-mono-relief" ]; then
  run slmaster-mono-relief slmaster-mono-relief/twin.toml "a real capture of a plaster relief"
else
  echo "fringetwin: no real captures at $captures (FRINGETWIN_CAPTURES), so none was run; make captures, in a checkout, fetches them" >&2
fi

# Earlier demos wrote a page of their own, which `index` would take for that of a stranger.
if grep -qs '<title>fringetwin demo</title>' "$out/index.html"; then rm "$out/index.html"; fi
"$program" index "$out" > /dev/null || exit

echo
echo "Reports (open in any browser, no network needed):"
echo "  file://$(realpath "$out/index.html")"
