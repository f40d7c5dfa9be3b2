#!/usr/bin/env bash
# What a build of the command line draws and finds, less what may differ between builds (times and
# the backend's name), so that builds can be compared byte for byte:
#   tools/detections.sh OUTPUT_FOLDER IMAGE_FOLDER COMMAND...
# Scenes of every family are rendered; they, and all images below the folder where it exists, are
# searched on the processor's backends, those with markers with both kinds of poses, too. The lines
# come in OUTPUT_FOLDER/detections.json, the pictures in OUTPUT_FOLDER/frames.
#   tools/detections.sh --compare FOLDER FOLDER
# fails where two such folders differ, and tells what was compared.
set -euo pipefail

if [[ $1 == --compare ]]; then
  diff -rq "$2" "$3"
  frames=("$3"/frames/*)
  echo "${#frames[@]} frames drawn, $(wc -l < "$3/detections.json") searches of images," \
    "$(grep -o '"family"' "$3/detections.json" | wc -l) markers: byte for byte the same"
  exit
fi
out=$1
images=$2
command=("${@:3}")
inner=(square circle hexagon)
outer=(square circle butterfly)
families=3x3,4x4,5x5,6x6,7x7,8x8

# Two markers, one of them small, in the shapes and light of this number.
scene() {
  local seed=$1 n=$((3 + $1 % 6)) shape=$(($1 / 6))
  local z=0.$((70 + 30 * n))
  cat <<EOF
{"camera": {"width": 480, "height": 320, "fx": 600, "fy": 600, "cx": 239.5, "cy": 159.5,
            "distortion_model": "brown", "distortion": [-0.15, 0.05, 0, 0, 0]},
 "background": $((60 + 50 * (seed % 4))), "blur": 0.$((5 + seed % 5)), "noise": $((seed % 4)),
 "seed": $seed,
 "markers": [
   {"family": "${n}x$n", "id": $((seed * 79 % 128)), "size": 0.05, "inner": "${inner[shape % 3]}",
    "outer": "${outer[(shape + 1) % 3]}",
    "rvec": [0.$((seed * 3 % 8)), -0.$((seed * 5 % 7)), 0.$((seed % 9))], "t": [-0.03, 0.005, $z]},
   {"family": "${n}x$n", "id": $((seed * 47 % 128)), "size": 0.02,
    "rvec": [0.$((seed % 6)), 0.$((seed % 5)), 2.$((seed % 7))], "t": [0.04, 0, $z]}]}
EOF
}

rm -rf "$out"
mkdir -p "$out/frames"
for seed in {0..23}; do
  scene "$seed" > "$out/scene.json"
  "${command[@]}" render "$out/scene.json" -o "$out/frames/$(printf %02d "$seed").png" \
    --write-camera "$out/camera.yaml" > /dev/null
done
inputs=(frames)
if [[ -d $images ]]; then
  mapfile -t -O 1 inputs < <(
    find -L "$(realpath "$images")" -regextype egrep -iregex '.*\.(jpg|png)' -printf '%h\n' | sort -u)
else
  echo "detections: no folder of images at $images: rendered ones only" >&2
fi
# Images of other sizes take the camera as theirs.
sed -i -E '/^image_(width|height):/d' "$out/camera.yaml"
cd "$out"
all=("${inputs[@]}")
for backend in simd scalar; do
  for pose in none vertices photometric; do
    options=()
    if [[ $pose != none ]]; then
      options=(--camera camera.yaml --tag-size 0.05 --pose "$pose")
    fi
    "${command[@]}" detect --format json --backend "$backend" --family "$families" --far on \
      --inverted --quality on "${options[@]}" "${inputs[@]}" |
      sed -E 's/"backend":"[^"]*",?//; s/,?"time_us":\{[^}]*\}//' > lines.json
    cat lines.json >> detections.json
    # Poses are a matter of images with markers only.
    if [[ $pose == none ]]; then
      mapfile -t inputs < <(sed -nE '/"family"/ s/.*"image":"([^"]*)".*/\1/p' lines.json)
    fi
  done
  inputs=("${all[@]}")
done
rm lines.json
