#!/usr/bin/env bash
# Memory safety of the core: builds it with the address and undefined-behaviour sanitizers in a
# folder of its own, runs its tests there, then the fuzzers that reach it.
#
#     benchmark/sanitize.sh FOLDER [SECONDS for each fuzzer] [fuzzer ...]
#
# Needs gcc, what the tests need, and for the fuzzers: pip install atheris.
set -euo pipefail
source=$(cd "$(dirname "$0")/.." && pwd)
folder=$1 seconds=${2:-60}
shift $(($# < 2 ? $# : 2))
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(joint_state program motion)
python=${PYTHON:-python3}

mkdir -p "$folder"
tar -C "$source" --exclude='*.so' --exclude=.git --exclude=build -c . | tar -C "$folder" -x
cd "$folder"
SCREW_KINEMATICS_FLAGS='-O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined' \
    "$python" setup.py -q build_ext --inplace
"$python" -c 'from screw_kinematics import core; assert core.build().compiled, core.build()'

# Python itself is not built with the sanitizers, whose libraries have to be loaded before it. What
# it keeps until it ends is no leak; its own allocator would hide small overruns.
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export PYTHONMALLOC=malloc PYTHONPATH=.
echo '== tests of the core'
LD_PRELOAD="$(gcc -print-file-name=libasan.so) $(gcc -print-file-name=libubsan.so)" \
    "$python" -m pytest -q -p no:cacheprovider test/core --deselect test/core/test_build.py \
    --ignore test/core/test_no_python_in_loops.py
library=$("$python" -c 'import atheris; print(atheris.path())')/asan_with_fuzzer.so
for target in "${targets[@]}"; do
    echo "== fuzzer $target, $seconds s"
    LD_PRELOAD=$library "$python" -m benchmark.fuzz "$target" --seconds "$seconds" --memory 3000
done
echo '== nothing found'
