#!/usr/bin/env bash
# Builds for 64-bit Arm on another machine and runs tests and command line under qemu-user: the
# parity suite on NEON and the emulation, then what the command line draws and finds, on a folder of
# images, too (tools/detections.sh), which must equal this machine's byte for byte. Needs the
# release build, and rights to install packages.
#   tools/test_aarch64.sh [IMAGE_FOLDER]
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
images=${1:-$root/../shared/data}
sysroot=$root/build/aarch64-root
build=$root/build/aarch64
libraries=$sysroot/usr/lib/aarch64-linux-gnu

"$root/tools/install_packages.sh" g++-aarch64-linux-gnu qemu-user mmdebstrap
if [[ ! -e $libraries/liblapack.so.3 ]]; then
  rm -rf "$sysroot"
  packages=(libc6-dev libstdc++-12-dev libhwy-dev libgtest-dev libopencv-dev libyaml-cpp-dev
    libcairo2-dev libjpeg-dev libpng-dev libwebp-dev
    libcli11-dev nlohmann-json3-dev)
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
cmake --build "$build" --target topotag_cli check_parity

"$root/tools/detections.sh" "$build/here" "$images" "$root/build/release/tools/topotag"
"$root/tools/detections.sh" "$build/there" "$images" \
  qemu-aarch64 -L "$sysroot" "$build/tools/topotag"
"$root/tools/detections.sh" --compare "$build/here" "$build/there"
