#!/usr/bin/env bash
# Sets up (packages, release build) and runs the whole test suite.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/release"

"$root/tools/install_packages.sh"
cmake -S "$root" --preset release
cmake --build "$build"
exec ctest --test-dir "$build" --output-on-failure --no-tests=error -j2
