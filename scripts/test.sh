#!/bin/sh
# Sets up what is missing, builds and runs all tests. Works alone, from any folder.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh
cmake --preset release
cmake --build --preset release
ctest --preset release "$@"
