#!/usr/bin/env bash
# DESIGN §2: which folder may include which. Fails on any other arrow; `--self-test` proves it can.
set -euo pipefail
root=${1:?source folder}

allowed() {
  case "$1" in
    twin) echo "twin" ;;
    render) echo "twin render" ;;
    measure) echo "twin measure" ;;
    report) echo "twin report" ;;
    calib) echo "twin measure report calib" ;;
    capture) echo "twin render capture" ;;
    compare) echo "twin render measure calib report compare" ;;
    study) echo "twin render measure calib report compare capture study" ;;
    cli) echo "twin render measure calib report compare capture study cli" ;;
  esac
}

scan() {
  local root=$1 status=0 folder file target
  for folder in twin render measure report calib capture compare study cli; do
    while IFS=: read -r file target; do
      case " $(allowed $folder) " in
        *" $target "*) ;;
        *) echo "upward include: ${file#"$root"/} includes $target/"; status=1 ;;
      esac
    done < <(grep -roE --include='*.cpp' --include='*.hpp' --include='*.h' '#include "(twin|render|measure|report|calib|capture|compare|study|cli)/' \
      "$root/$folder" 2>/dev/null | sed -E 's/#include "([a-z]+)\//\1/')
  done
  return $status
}

# The test must be able to fail: an upward include in a scratch tree is found.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$scratch/twin"
echo '#include "render/renderer.hpp"' >"$scratch/twin/bad.cpp"
if scan "$scratch" >/dev/null; then
  echo "include_direction: the check does not see a planted upward include"
  exit 1
fi
scan "$root" && echo "include directions as DESIGN §2 says"
