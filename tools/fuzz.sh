#!/usr/bin/env bash
# Builds the fuzz targets of tests/fuzz with clang's libFuzzer and the address and undefined
# behaviour sanitizers, makes their seeds, and runs each for so long; then prints what came out.
#   tools/fuzz.sh [SECONDS_PER_TARGET [TARGET...]]        (default: 1200 seconds, all targets)
# The seconds are CPU time of the target, so a busy machine makes a run longer, not shallower.
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

clock_ticks=$(getconf CLK_TCK)

# The CPU seconds a process has used; nothing once it has ended.
cpu_seconds() {
  awk -v ticks="$clock_ticks" '{ sub(/^.*\) /, ""); print int(($12 + $13) / ticks) }' \
    "/proc/$1/stat" 2>/dev/null || true
}

# Runs a fuzz program until it has used the CPU time and then asks it to end, which makes it
# print its figures; `cpu` gets the time used, the result is the program's.
run_for_cpu_time() {
  local log=$1 fuzzer now
  shift
  "$@" >"$log" 2>&1 &
  fuzzer=$!
  trap 'kill "$fuzzer"' EXIT
  cpu=0
  while now=$(cpu_seconds "$fuzzer") && [[ -n $now ]]; do
    cpu=$now
    if ((cpu >= seconds)); then
      kill -USR1 "$fuzzer"
      break
    fi
    sleep 1
  done
  trap - EXIT
  wait "$fuzzer"
}

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
  options=(-timeout=300 -rss_limit_mb=4096 -malloc_limit_mb=512 -print_final_stats=1
    -artifact_prefix="$findings/")
  dictionary="$root/tests/fuzz/$target.dict"
  [[ -f $dictionary ]] && options+=(-dict="$dictionary")
  echo "fuzz: $target for $seconds s of CPU time"
  result="no finding"
  if ! run_for_cpu_time "$log" "$build/tests/fuzz/fuzz_$target" "${options[@]}" "$corpus"; then
    result="FINDING, see $log"
    status=1
  fi
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  coverage=$(grep -oE 'cov: [0-9]+ ft: [0-9]+ corp: [0-9]+' "$log" | tail -n 1 || true)
  summary+=("$(printf '%-14s %10s executions in %5d s of CPU time  %s  %s' \
    "$target" "${executions:-?}" "$cpu" "$coverage" "$result")")
done
printf '%s\n' "${summary[@]}"
exit "$status"
