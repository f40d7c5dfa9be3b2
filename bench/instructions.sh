#!/usr/bin/env bash
# Instructions a frame of each stage on one thread, by callgrind: exact where times are not. Second
# looks are counted with the stages that they run. Needs valgrind, which has AVX2 at most.
#   bench/instructions.sh BUILD_FOLDER [BACKEND...]     (default: scalar simd)
set -euo pipefail

program=${1:?usage: bench/instructions.sh BUILD_FOLDER [BACKEND...]}/bench/counted_frames
shift
backends=("$@")
((${#backends[@]})) || backends=(scalar simd)
frames=3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Column title and the function, as callgrind_annotate writes it, whose inclusive count it is.
stages=(
  'thresh+bin=Backend::Binarize\('
  'label=Backend::Label\('
  'tree=TopologyTree::Find\('
  'decode=topotag::Decode\('
  'bits=topotag::ConfirmBits\('
  'vertices=topotag::RefineVertices\('
  'pose=Impl::EstimatePoses\('
  'total=bench::CountedFrames\('
)

printf '%-8s %-18s' backend '1280x960, 1 thread'
for stage in "${stages[@]}"; do printf ' %12s' "${stage%%=*}"; done
printf '\n'
for backend in "${backends[@]}"; do
  for scene in 1_marker 20_markers 20_markers_photo 20_markers_mosaic noise; do
    out=$scratch/$backend.$scene
    if ! valgrind --tool=callgrind --callgrind-out-file="$out" --collect-atstart=no \
      --toggle-collect='topotag::bench::CountedFrames*' \
      "$program" "$backend" "$scene" 1280 960 $frames >"$scratch/log" 2>&1; then
      echo "$backend, $scene: $(grep -v '^==' "$scratch/log" | tail -1)" >&2
      continue
    fi
    callgrind_annotate --inclusive=yes --threshold=100 "$out" >"$scratch/functions"
    printf '%-8s %-18s' "$backend" "$scene"
    for stage in "${stages[@]}"; do
      # Of several, the outermost: the largest.
      count=$(grep -E "${stage#*=}" "$scratch/functions" | awk '{gsub(",", "", $1); print $1}' |
        sort -n | tail -1 || true)
      printf ' %12s' "$((${count:-0} / frames))"
    done
    printf '\n'
  done
done
