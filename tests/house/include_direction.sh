#!/usr/bin/env bash
# Which folder may include which (docs/ARCHITECTURE.md). include_direction.sh ROOT fails on any other arrow, however it is
# written; include_direction.sh --self-test proves that it can.
set -euo pipefail

folders=(twin render measure report calib capture compare study cli)

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

# scan ROOT: every include of one of our folders, as "..." or <...>, with blanks, with ./ or ../ before it.
scan() {
  local root=$1 status=0 scanned=0 folder file target
  local names
  names=$(IFS='|'; echo "${folders[*]}")
  for folder in "${folders[@]}"; do
    [ -d "$root/$folder" ] || continue
    scanned=$((scanned + $(find "$root/$folder" -name '*.[ch]pp' -o -name '*.h' -o -name '*.comp' -o -name '*.glsl' | wc -l)))
    while IFS=: read -r file target; do
      case " $(allowed "$folder") " in
        *" $target "*) ;;
        *) echo "upward include: ${file#"$root"/} includes $target/"; status=1 ;;
      esac
    done < <(grep -roE --include='*.cpp' --include='*.hpp' --include='*.h' --include='*.comp' --include='*.glsl' \
      "^[[:space:]]*#[[:space:]]*include[[:space:]]*[\"<](\.{1,2}/)*($names)/" "$root/$folder" |
      sed -E "s~:[^:]*[\"</]($names)/\$~:\1~")
  done
  if [ "$scanned" -eq 0 ]; then
    echo "include_direction: no source file of ours under $root"
    return 1
  fi
  return $status
}

# Every planted include must be seen, each alone; a tree without any must pass, one without sources must not.
self_test() {
  local include n=0
  scratch=$(mktemp -d)
  trap 'rm -rf "$scratch"' EXIT
  mkdir -p "$scratch/twin/sub" "$scratch/empty"
  expect_refused() {
    if scan "$scratch" >"$scratch/said"; then
      echo "include_direction: does not see: $1"
      exit 1
    fi
    grep -q "upward include: .* includes render/" "$scratch/said" || { echo "wrong answer for: $1"; exit 1; }
  }
  while IFS= read -r include; do
    echo "$include" >"$scratch/twin/sub/bad.hpp"
    expect_refused "$include"
    n=$((n + 1))
  done <<'END'
#include "render/renderer.hpp"
#include <render/renderer.hpp>
# include "render/renderer.hpp"
  #  include  <render/renderer.hpp>
#include "../render/renderer.hpp"
#include "./../../render/renderer.hpp"
#include"render/renderer.hpp"
END
  printf '#include "twin/lens/pose.hpp"\n#include <vector>\n// see "render/renderer.hpp"\n' >"$scratch/twin/sub/bad.hpp"
  if ! scan "$scratch"; then
    echo "include_direction: refuses includes that are allowed"
    exit 1
  fi
  if scan "$scratch/empty" >/dev/null || scan "$scratch/none" >/dev/null; then
    echo "include_direction: passes a tree without sources"
    exit 1
  fi
  echo "include_direction: sees all $n planted upward includes"
}

if [ "${1:?--self-test or the source folder}" = --self-test ]; then
  self_test
else
  scan "$1"
  echo "include directions as tests/house/rooms.txt says"
fi
