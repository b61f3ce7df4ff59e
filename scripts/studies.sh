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
