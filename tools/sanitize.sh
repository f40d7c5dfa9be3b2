#!/usr/bin/env bash
# Sets up (packages, builds with sanitizers) and runs the whole test suite in them:
#   tools/sanitize.sh [address|thread] [CTEST_ARGUMENT...]
# address: accesses, leaks and undefined behaviour; thread: data races. Without a name, both.
# clang, where it is installed, builds faster than gcc; CXX=g++ takes the other one.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/tools/install_packages.sh"

run() {
  local preset=$1
  shift
  (
    cd "$root"
    cmake --preset "$preset" -DCMAKE_CXX_COMPILER="${CXX:-$(command -v clang++ || command -v c++)}"
    cmake --build --preset "$preset"
    ctest --preset "$preset" "$@"
  )
}

case "${1:-}" in
  address) run asan "${@:2}" ;;
  thread) run tsan "${@:2}" ;;
  "") run asan && run tsan ;;
  *)
    echo "sanitize: '$1' is not address or thread" >&2
    exit 2
    ;;
esac
