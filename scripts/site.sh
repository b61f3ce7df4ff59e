#!/usr/bin/env bash
# site.sh [OUT]: README.md, docs/ and what they link to as a searchable static site in OUT (default out/site). It needs
# mkdocs and no network, and neither does reading it: open OUT/index.html.
# The pages lie in the site as in the sources, so that their links lead to the same places.
set -euo pipefail
out=$(realpath -m "${1:-out/site}")
# mkdocs empties the folder first
if [ -n "$(ls -A "$out" 2>/dev/null)" ] && [ ! -f "$out/search/search_index.js" ] && [ ! -f "$out/search/search_index.json" ]; then
  echo "site.sh: error: $out has files, and they are no site: give another folder" >&2
  exit 2
fi
cd "$(dirname "$0")/.."
staged=$(mktemp -d)
trap 'rm -rf "$staged"' EXIT
cp --parents -r README.md CHANGELOG.md CONTRIBUTING.md LICENSE docs datasets/README.md tests/house/rooms.txt "$staged"
find datasets -name '*.toml' -exec cp --parents {} "$staged" ';'
FRINGETWIN_SITE_SOURCES=$staged PYTHONDONTWRITEBYTECODE=1 \
  mkdocs build --strict --quiet --clean --config-file scripts/site/mkdocs.yml --site-dir "$out"
echo "file://$out/index.html"
