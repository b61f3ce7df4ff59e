#!/usr/bin/env bash
# Unpacks Debian's newer software Vulkan driver (Mesa 25 of bookworm-backports) into drivers/mesa25, beside the
# system's own: no package is installed, no apt source is changed. Prints the variable that chooses it.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
to=$here/drivers/mesa25
icd=$to/icd.json
if [ ! -f "$icd" ]; then
  echo "fringetwin: fetching mesa-vulkan-drivers (11 MB) from Debian's bookworm-backports into drivers/mesa25" >&2
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  mkdir -p "$work/lists/partial" "$work/cache/archives/partial"
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] ${FRINGETWIN_DEBIAN:-http://deb.debian.org/debian} bookworm-backports main" \
    >"$work/sources.list"
  options=(-qq -o Dir::Etc::sourcelist="$work/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o Dir::State::lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)")
  (cd "$work" && apt-get "${options[@]}" update && apt-get "${options[@]}" download mesa-vulkan-drivers/bookworm-backports)
  dpkg-deb -x "$work"/mesa-vulkan-drivers_*.deb "$work/unpacked"
  library=$to/libvulkan_lvp.so
  mkdir -p "$to"
  cp "$work"/unpacked/usr/lib/*/libvulkan_lvp.so "$library"
  if ldd "$library" | grep -q 'not found'; then
    echo "scripts/get_mesa25.sh: libraries are missing on this system:" >&2
    ldd "$library" | grep 'not found' >&2
    rm -rf "$to"
    exit 2
  fi
  sed "s#\"libvulkan_lvp.so\"#\"$library\"#" "$work"/unpacked/usr/share/vulkan/icd.d/lvp_icd*.json >"$icd.tmp"
  mv "$icd.tmp" "$icd" # last: its presence says that the rest is complete
fi
echo "VK_ICD_FILENAMES=$icd"
