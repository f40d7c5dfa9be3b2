#!/usr/bin/env bash
# Sets up (packages, builds with sanitizers) and runs the whole test suite in them:
#   tools/sanitize.sh [--quick] [address|thread] [CTEST_ARGUMENT...]
# address: accesses, leaks and undefined behaviour; thread: data races. Without a name, both.
# --quick: only the tests labelled so (tests/CMakeLists.txt): all but the longest; of thread, those
# in which several threads are at work.
# With clang, which builds this faster than gcc; CXX=g++ takes the other one.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

targets=(all)
tests=()
if [[ ${1:-} == --quick ]]; then
  targets=(quick_tests)
  tests=(--label-regex quick)
  shift
fi

if [[ -v CXX ]]; then
  "$root/tools/install_packages.sh"
else
  "$root/tools/install_packages.sh" clang libclang-rt-dev llvm
fi

run() {
  local preset=$1
  shift
  (
    cd "$root"
    cmake --preset "$preset" -DCMAKE_CXX_COMPILER="${CXX:-clang++}"
    cmake --build --preset "$preset" --target "${targets[@]}"
    ctest --preset "$preset" "${tests[@]}" "$@"
  )
}

case "${1:-}" in
  address) run asan "${@:2}" ;;
  thread) run tsan "${@:2}" ;;
  "")
    run asan
    run tsan
    ;;
  *)
    echo "sanitize: '$1' is not address or thread" >&2
    exit 2
    ;;
esac
