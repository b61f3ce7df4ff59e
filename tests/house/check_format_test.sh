#!/usr/bin/env bash
# scripts/check_format.sh must be able to fail: on a badly formatted file, without a checkout, without its tools.
# check_format_test.sh ROOT
set -euo pipefail
root=${1:?source folder}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir "$scratch/scripts" "$scratch/bin"
cp "$root/scripts/check_format.sh" "$scratch/scripts/"
cp "$root/.clang-format" "$scratch/"

expect() { # CODE WORDS ENVIRONMENT...
  local code=$1 words=$2 status=0
  shift 2
  env "$@" bash "$scratch/scripts/check_format.sh" >"$scratch/said" 2>&1 || status=$?
  if [ "$status" -ne "$code" ] || ! grep -q "$words" "$scratch/said"; then
    echo "check_format: expected exit $code and \"$words\", got $status and:"
    cat "$scratch/said"
    exit 1
  fi
}

expect 2 "git lists no C++ file" GIT_CEILING_DIRECTORIES="$(dirname "$scratch")"
git -C "$scratch" init -q
printf 'int main() { return 0; }\n' >"$scratch/good.cpp"
git -C "$scratch" add good.cpp
expect 0 "all 1 C++ files"
printf 'int  f( ){return 0;}\n' >"$scratch/with blank.cpp"
git -C "$scratch" add "with blank.cpp"
expect 1 "^with blank.cpp"
ln -s "$(command -v bash)" "$(command -v dirname)" "$(command -v git)" "$scratch/bin/"
expect 2 "clang-format is missing" PATH="$scratch/bin"
rm "$scratch/bin/git"
expect 2 "git is missing" PATH="$scratch/bin"
echo "check_format.sh fails where it should"
