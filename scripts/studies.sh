#!/usr/bin/env bash
# scripts/studies.sh OUT: runs the shipped studies and draws the pictures of docs/STUDIES.md anew.
set -euo pipefail
out=$1
for file in datasets/studies/*.toml; do
  name=$(basename "$file" .toml)
  grep -q fringetwin-study/1 "$file" || continue
  echo "$name"
  build/fringetwin study "$file" --figures --out "$out/$name" || [ $? -eq 5 ] # not converged is a result, too
done
# picture STUDY FIGURE
picture() { cp "$out/$1/figures/$2.svg" "docs/images/study-$1.svg"; }
picture bit-depth rms_mm-bit_depth-mean
picture bit-depth-sphere rms_mm-bit_depth-mean
picture noise-sphere center_z_mm-read_noise_dn-sigma
picture pitch rms_mm-pitches_px-3-mean
picture samples rms_mm-samples-mean
picture volume-edge rms_mm-center_mm-0-mean
picture surface-angle rms_mm-normal-0-mean
picture uncertainty radius_mm-tornado
picture volume-map spacing-sigma
picture optimise front
picture thousand center_z_mm-read_noise_dn-sigma
