#!/usr/bin/env bash
# get_captures.sh [--target DIR] [--mirror DIR] [SET ...]: the public real captures, each from its repository at its
# commit, checked; get_captures.py does it and says more with --help.
set -u
here=$(cd "$(dirname "$0")" && pwd)
for needed in git python3; do
  if ! command -v "$needed" >/dev/null; then
    echo "get_captures: $needed is not installed; run make deps" >&2
    exit 2
  fi
done
exec python3 "$here/get_captures.py" "$@"
