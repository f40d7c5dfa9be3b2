#!/usr/bin/env bash
# Sets up (packages, release build) and detects markers.
#   tools/demo.sh             renders docs/demo_scene.json and detects it, with poses
#   tools/demo.sh IMAGE...    detects on your own pictures; options of `topotag detect` may stand
#                             among them, e.g. --camera camera.yaml --tag-size 0.05
# Annotated pictures are written to out/draw in the project's folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/release"
out="$root/out"

"$root/tools/install_packages.sh"
cmake -S "$root" --preset release
cmake --build "$build" --target topotag_cli

topotag="$build/tools/topotag"
mkdir -p "$out/draw"
if (($# == 0)); then
  "$topotag" render "$root/docs/demo_scene.json" -o "$out/scene.png" \
    --truth "$out/scene_truth.json" --write-camera "$out/scene_camera.yaml"
  echo "Rendered $out/scene.png; detecting:"
  set -- --camera "$out/scene_camera.yaml" --tag-size 0.05 "$out/scene.png"
fi
"$topotag" detect --draw "$out/draw" "$@"
echo "Annotated pictures: $out/draw"
