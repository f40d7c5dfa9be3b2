#!/usr/bin/env bash
# Sets up (packages, a build that counts executed lines), runs the whole test suite and prints the
# line coverage of fallback/, simd/ and host/; fails where a folder is below 90 %.
#   tools/coverage.sh [CTEST_ARGUMENT...]
# Every line is shown in build/coverage/html/index.html. Where Highway compiles a file once for each
# target, a line counts when any of them executes it.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/coverage"
counts="$build/coverage.json"

"$root/tools/install_packages.sh" gcovr
cd "$root"
cmake --preset coverage
cmake --build --preset coverage
find "$build" -name '*.gcda' -delete
status=0
# Nobody else can link the package of a build that counts, and where files may not grow, counts
# cannot be written.
ctest --preset coverage --exclude-regex '^Install|AFullDisk' "$@" || status=1

# The library's objects alone: what else compiles a header of host/ is no test of it.
gcovr --root "$root" --filter "$root/(fallback|simd|host)/" --json "$counts" -j2 \
  "$build/CMakeFiles/topotag.dir" "$build/CMakeFiles/topotag_io.dir"
mkdir -p "$build/html"
gcovr --root "$root" --add-tracefile "$counts" --html-details "$build/html/index.html"
for folder in fallback simd host; do
  gcovr --root "$root" --add-tracefile "$counts" --filter "$root/$folder/" --fail-under-line 90 ||
    status=1
done
exit "$status"
