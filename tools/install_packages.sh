#!/usr/bin/env bash
# Installs the Debian packages that the build, the tests and the tools need. Needs no network
# and no rights where all of them are there already.
#   install_packages.sh [FURTHER_PACKAGE...]
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config
  libhwy-dev
  libopencv-dev libyaml-cpp-dev libcairo2-dev libjpeg-dev libpng-dev libwebp-dev
  libcli11-dev nlohmann-json3-dev
  opencl-headers ocl-icd-opencl-dev pocl-opencl-icd
  libgtest-dev libbenchmark-dev
  libapriltag-dev libopencv-contrib-dev  # other systems, in benchmarks
  poppler-utils librsvg2-bin  # pictures of PDF and SVG, in tests
  "$@"
)

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "install_packages: not a Debian system; install the equivalents of: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "install_packages: must be root, or have sudo, to install: ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

apt_get() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -q -o DPkg::Lock::Timeout=300 "$@"
}

echo "Installing: ${missing[*]}"
apt_get update
apt_get install -y --no-install-recommends "${missing[@]}"
