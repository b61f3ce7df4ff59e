#!/usr/bin/env bash
# Installs what packages.txt names and is not there yet, and says so first.
# No question when stdin is no terminal; sudo only where needed.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
mapfile -t wanted < <(sed 's/#.*//' "$here/packages.txt" | tr -s ' \t' '\n' | sed '/^$/d')

missing=()
for package in "${wanted[@]}"; do
  if ! dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed'; then
    missing+=("$package")
  fi
done
if [ ${#missing[@]} -eq 0 ]; then
  exit 0
fi

echo "fringetwin needs these Debian packages (packages.txt) and will install them with apt-get:" >&2
printf '  %s\n' "${missing[@]}" >&2
if [ -t 0 ] && [ "${CI:-}" != true ]; then
  read -r -p "Install them now? [Y/n] " answer
  case "$answer" in n* | N*) echo "Not installed. Install them yourself, then run the command again." >&2; exit 2 ;; esac
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "scripts/install_packages.sh: not root and no sudo; install the packages above as root, then run the command again" >&2
    exit 2
  fi
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends -qq "${missing[@]}" >/dev/null
