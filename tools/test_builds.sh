#!/usr/bin/env bash
# Builds the project in the ways that a user may choose, runs tests of each build, and compares what
# its command line draws and finds with the release build's, byte for byte:
#   tools/test_builds.sh [VARIANT...]        (default: all of them; a minute to ten each)
# core       Highway alone, where no OpenCL, no OpenCV and no other library can be found; clang
# no_opencl  without the opencl backend; all tests
# clang      the other compiler
# emulation  the simd backend as on a processor that Highway has no instructions of
# shared     shared libraries, installed and used from there
# Images to compare on: TOPOTAG_IMAGES, a folder. Needs the release build, but for core.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
images=${TOPOTAG_IMAGES:-$root/../shared/data}
builds=$root/build
variants=("$@")
((${#variants[@]} > 0)) || variants=(core no_opencl clang emulation shared)

# A build of variant $1 with these options, in $build.
configure() {
  build=$builds/$1
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTOPOTAG_BUILD_BENCH=OFF \
    "${@:2}"
}

check_parity() { cmake --build "$build" --target check_parity; }

compare() {
  cmake --build "$build" --target topotag_cli
  "$root/tools/detections.sh" "$build/detections" "$images" "$build/tools/topotag"
  "$root/tools/detections.sh" --compare "$builds/detections" "$build/detections"
}

core() {
  local missing=() name
  for name in OpenCL OpenCV yaml-cpp JPEG PNG PkgConfig CLI11 nlohmann_json; do
    missing+=("-DCMAKE_DISABLE_FIND_PACKAGE_$name=ON")
  done
  configure core -DCMAKE_CXX_COMPILER=clang++ -DTOPOTAG_OPENCL=OFF -DTOPOTAG_BUILD_IO=OFF \
    -DTOPOTAG_BUILD_TOOLS=OFF "${missing[@]}"
  check_parity
}

no_opencl() {
  configure no_opencl -DTOPOTAG_OPENCL=OFF
  cmake --build "$build"
  ctest --test-dir "$build" --output-on-failure --no-tests=error -j2
  compare
}

clang() {
  configure clang -DCMAKE_CXX_COMPILER=clang++
  check_parity
  compare
}

emulation() {
  configure emulation -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_EMU128
  check_parity
  compare
}

shared() {
  configure shared -DBUILD_SHARED_LIBS=ON
  check_parity
  compare
  ctest --test-dir "$build" --output-on-failure --no-tests=error -R '^Install\.'
}

# Out of variant $1's log.
summary() {
  local log=$builds/$1.log passed compared
  passed=$(sed -nE 's/.*\[  PASSED  \] ([0-9]+) .*/\1/p; s/.*tests passed.* out of ([0-9]+)/\1/p' \
    "$log" | paste -sd+)
  compared=$(grep ' frames drawn' "$log" || echo "no command line to compare")
  echo "$1: $((passed)) tests passed; $compared; $SECONDS s"
}

for variant in "${variants[@]}"; do
  case $variant in
    core | no_opencl | clang | emulation | shared) ;;
    *)
      echo "test_builds: no variant is named '$variant'" >&2
      exit 2
      ;;
  esac
done
"$root/tools/install_packages.sh" clang
mkdir -p "$builds"
if [[ ${variants[*]} != core ]]; then
  "$root/tools/detections.sh" "$builds/detections" "$images" "$root/build/release/tools/topotag"
fi
failed=0
for variant in "${variants[@]}"; do
  SECONDS=0
  # Not as a condition, where an error would not end it.
  set +e
  (set -e; "$variant") > "$builds/$variant.log" 2>&1
  status=$?
  set -e
  if ((status == 0)); then
    summary "$variant"
  else
    tail -n 40 "$builds/$variant.log"
    echo "$variant: FAILED; $builds/$variant.log"
    failed=1
  fi
done
exit "$failed"
