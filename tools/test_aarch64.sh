#!/usr/bin/env bash
# Builds for 64-bit Arm on another machine and runs tests and command line under qemu-user: the
# parity suite on NEON and the emulation, then detections on a folder of images, which must equal
# this machine's byte for byte. Needs the release build, and rights to install packages.
#   tools/test_aarch64.sh [IMAGE_FOLDER]
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
images=${1:-$root/../shared/data/topotag_real}
sysroot=$root/build/aarch64-root
build=$root/build/aarch64
libraries=$sysroot/usr/lib/aarch64-linux-gnu
parity='(threshold|binarize|label|segmentation|detector)_parity_test|centroid_test|upsample_test'

"$root/tools/install_packages.sh" g++-aarch64-linux-gnu qemu-user mmdebstrap
if [[ ! -e $libraries/liblapack.so.3 ]]; then
  rm -rf "$sysroot"
  packages=(libc6-dev libstdc++-12-dev libhwy-dev libgtest-dev libopencv-dev libyaml-cpp-dev
    libcairo2-dev libjpeg-dev libpng-dev libcli11-dev nlohmann-json3-dev)
  mmdebstrap --quiet --architectures=arm64 --variant=extract \
    --aptopt='APT::Install-Recommends "false"' --include="$(IFS=,; echo "${packages[*]}")" \
    bookworm "$sysroot"
  # Alternatives are linked when packages are configured, which extraction leaves out.
  ln -s blas/libblas.so.3 "$libraries/libblas.so.3"
  ln -s lapack/liblapack.so.3 "$libraries/liblapack.so.3"
fi

cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_TOOLCHAIN_FILE="$root/cmake/aarch64.cmake" -DTOPOTAG_SYSROOT="$sysroot" \
  -DTOPOTAG_OPENCL=OFF -DTOPOTAG_BUILD_BENCH=OFF
mapfile -t tests < <(ninja -C "$build" -t targets all |
  sed -n 's/^\([a-z0-9_]*_test\): phony$/\1/p' | grep -xE "$parity")
ninja -C "$build" topotag_cli "${tests[@]}"
for test in "${tests[@]}"; do
  echo "$test under qemu"
  qemu-aarch64 -L "$sysroot" "$build/tests/$test" --gtest_brief=1
done

if [[ ! -d $images ]]; then
  echo "test_aarch64: no folder of images at $images: detections are not compared" >&2
  exit 0
fi
# Everything but the backend's name and the times is the same everywhere.
detect() {
  "$@" detect --format json --far on --inverted on "$images" |
    sed -E 's/"backend":"[^"]*",?//; s/"time_us":\{[^}]*\}//'
}
detect "$root/build/release/tools/topotag" > "$build/here.json"
detect qemu-aarch64 -L "$sysroot" "$build/tools/topotag" > "$build/there.json"
cmp "$build/here.json" "$build/there.json"
echo "$(wc -l < "$build/here.json") images, $(grep -o '"family"' "$build/here.json" | wc -l)" \
  "markers: byte for byte the same on aarch64"
