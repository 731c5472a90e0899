#!/bin/sh
# Builds the release benchmarks and runs them: sh scripts/bench.sh [name ...]; all when none named.
# Each writes bench/<name>.json (medians, spreads, ratios, the machine).
set -eu
cd "$(dirname "$0")/.."
. scripts/setup.sh
cmake --preset release -DWHEATSTONE_TESTS=OFF -DWHEATSTONE_BENCH=ON -B build/bench
cmake --build build/bench
if [ $# = 0 ]; then
  for program in build/bench/bin/*_bench; do
    name=$(basename "$program")
    set -- "$@" "${name%_bench}"
  done
fi
for name in "$@"; do
  "build/bench/bin/${name}_bench" --json "bench/$name.json"
done
