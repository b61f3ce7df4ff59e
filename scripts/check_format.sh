#!/usr/bin/env bash
# Fails, naming the files, when a C++ file is not formatted as .clang-format says.
set -euo pipefail
cd "$(dirname "$0")/.."
bad=$(git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run 2>&1 | grep -oE '^[^:]+\.[ch]pp' | sort -u || true)
if [ -n "$bad" ]; then
  echo "not formatted (run: make format):" >&2
  echo "$bad" >&2
  exit 1
fi
echo "format: all C++ files as .clang-format says"
