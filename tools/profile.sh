#!/usr/bin/env bash
# Sets up (packages, release build), times everything and writes out/profile.html and
# out/profile.json in the project's folder.
#   tools/profile.sh [--photos DIR] [--quick]
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/release"
out="$root/out"

"$root/tools/install_packages.sh"
cmake -S "$root" --preset release
cmake --build "$build" --target topotag_profile
mkdir -p "$out"
exec "$build/bench/profile" --output "$out/profile.html" --json "$out/profile.json" "$@"
