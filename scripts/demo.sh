#!/bin/sh
# Sets up what is missing, builds, and runs the whole way: the simulated rig and both real inputs.
# The real inputs are read from $WHEATSTONE_SHARED (default ../shared); without them only the
# simulated part runs, and says so.
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh
cmake --preset release -DWHEATSTONE_TESTS=OFF -B build/demo
cmake --build build/demo
shared="${WHEATSTONE_SHARED:-../shared}"
if [ -d "$shared/data" ]; then
  build/demo/bin/wheatstone demo --out out/demo --real "$shared/data" "$@"
else
  echo "no real input at $shared/data: running the simulated part only"
  build/demo/bin/wheatstone demo --out out/demo "$@"
fi
