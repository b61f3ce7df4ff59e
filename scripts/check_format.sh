#!/usr/bin/env bash
# Fails, naming the files, when a C++ file is not formatted as .clang-format says; and when it cannot tell.
set -euo pipefail
cd "$(dirname "$0")/.."
for tool in git clang-format; do
  if ! command -v "$tool" >/dev/null; then
    echo "check_format: $tool is missing (packages.txt names it; run: make deps)" >&2
    exit 2
  fi
done
mapfile -d '' -t files < <(git ls-files -z '*.cpp' '*.hpp')
if [ ${#files[@]} -eq 0 ]; then
  echo "check_format: git lists no C++ file here (a checkout is needed)" >&2
  exit 2
fi
status=0
output=$(clang-format --dry-run -Werror "${files[@]}" 2>&1) || status=$?
if [ "$status" -ne 0 ]; then
  echo "not formatted (run: make format):" >&2
  # What clang-format says about itself (a bad .clang-format) has no such line and is shown whole.
  grep -E '^[^:]+\.[ch]pp:' <<<"$output" | cut -d: -f1 | sort -u >&2 || echo "$output" >&2
  exit 1
fi
echo "format: all ${#files[@]} C++ files as .clang-format says"
