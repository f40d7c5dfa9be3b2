#!/usr/bin/env bash
# Builds the fuzz targets of tests/fuzz with clang's libFuzzer and the address and undefined
# behaviour sanitizers, makes their seeds, and runs each for so long; then prints what came out.
#   tools/fuzz.sh [SECONDS_PER_TARGET [TARGET...]]        (default: 1200 seconds, all targets)
# Inputs that reach new code stay in build/fuzz/corpus, where the next run goes on; findings are
# written to build/fuzz/findings, and build/fuzz/tests/fuzz/fuzz_TARGET FILE repeats one.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/fuzz"
seconds=${1:-1200}
shift || true
targets=("$@")
((${#targets[@]} > 0)) || targets=(images camera text_files options kernel_cache encoded_image)

if ! command -v clang++ >/dev/null; then
  echo "fuzz: clang++ is missing; on Debian: apt-get install clang" >&2
  exit 1
fi
"$root/tools/install_packages.sh"
cmake -S "$root" --preset fuzz
programs=()
for target in "${targets[@]}"; do programs+=("fuzz_$target" "fuzz_${target}_runs"); done
cmake --build "$build" --target "${programs[@]}"

export ASAN_OPTIONS="detect_stack_use_after_return=1:${ASAN_OPTIONS:-}"
export UBSAN_OPTIONS="print_stacktrace=1:${UBSAN_OPTIONS:-}"
status=0
summary=()
for target in "${targets[@]}"; do
  corpus="$build/corpus/$target"
  findings="$build/findings/$target"
  log="$build/$target.log"
  mkdir -p "$corpus" "$findings"
  "$build/tests/fuzz/fuzz_${target}_runs" --seeds "$corpus"
  options=(-max_total_time="$seconds" -timeout=60 -rss_limit_mb=4096 -print_final_stats=1
    -artifact_prefix="$findings/")
  dictionary="$root/tests/fuzz/$target.dict"
  [[ -f $dictionary ]] && options+=(-dict="$dictionary")
  echo "fuzz: $target for $seconds s"
  result="no finding"
  if ! "$build/tests/fuzz/fuzz_$target" "${options[@]}" "$corpus" >"$log" 2>&1; then
    result="FINDING, see $log"
    status=1
  fi
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  coverage=$(grep -oE 'cov: [0-9]+ ft: [0-9]+ corp: [0-9]+' "$log" | tail -n 1 || true)
  summary+=("$(printf '%-14s %10s executions  %s  %s' "$target" "${executions:-?}" \
    "$coverage" "$result")")
done
printf '%s\n' "${summary[@]}"
exit "$status"
