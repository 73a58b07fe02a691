# test_nightly.sh: script/test --nightly. Sourced, after test_runs.sh. Every phase runs, whatever became of those before.
# shellcheck shell=bash

nights=$root/build/nights # kept from night to night: what was unsteady, and the page of each night

# The tests' own time limits are for the sizes of CI. The copy of ctest's files in build/ gets those of a night: 20 times as
# long, at most four hours; or the one that is asked for.
set_timeouts() { # set_timeouts FOLDER LIMIT
    find "$1" -name CTestTestfile.cmake -exec env limit="$2" perl -pi -e '
        BEGIN { $limit = $ENV{limit} }
        sub of_night { my $s = 20 * $_[0]; $limit || ($s < 14400 ? $s : $_[0] > 14400 ? $_[0] : 14400) }
        s/TIMEOUT "(\d+)"/"TIMEOUT \"" . of_night($1) . "\""/e' {} +
}

results=() # name=file of each phase
broken=    # phases that could not be run at all
ready() { # ready NAME COMMAND...: a build, or a check; false: nothing can be tested with it
    if ! "${@:2}"; then
        say "failed: $1"
        broken+="$1 "
        return 1
    fi
}
phase() { # phase NAME COMMAND...: the command gets the options for ctest at its end
    local file
    file=$tonight/${#results[@]}.xml
    results+=("$1=$file")
    "${@:2}" --output-junit "$file" || true
}

# What failed among tests of processes runs once more, alone; the page reads both.
talk_at_night() { # talk_at_night PRESET --output-junit FILE
    run_tests "$1" $((3 * $(nproc))) -L "$of_processes" "${@:2}" || run_again "$1" "${@:2:1}" "${3%.xml}-again.xml"
}

build_for_night() { # build_for_night PRESET LIMIT [cmake options...]
    (build "$1" "${@:3}") && set_timeouts "build/$1" "$2"
}

run_night() { # run_night LIMIT
    local limit=$1 seconds=1800 held=0
    tonight=$nights/$(date +%F.%H%M)
    mkdir -p "$tonight"
    [ -z "$limit" ] || [ "$limit" -gt "$seconds" ] || seconds=$limit

    ready "format and clang-tidy of all files" script/lint --tidy || true

    export COLLIDED_NIGHTLY=1 COLLIDED_WEEKLY=1
    if ready "build release" build_for_night release "$limit"; then
        phase "release, sizes of the night and of the week" compute release
        phase "release, processes at night" talk_at_night release
    fi
    ready "proofs of the checker of certificates" script/prove || true
    ready "mutants of the checker of certificates" tests/check/mutate build/release || true
    unset COLLIDED_NIGHTLY COLLIDED_WEEKLY # what follows is slow: the sizes of a release in CI
    if ready "build asan-ubsan" build_for_night asan-ubsan "$limit"; then
        phase "ASan, UBSan and asserts" compute asan-ubsan
        phase "ASan, UBSan and asserts, processes" talk_at_night asan-ubsan
    fi
    if ready "build tsan" build_for_night tsan "$limit"; then
        phase "TSan" run_tests tsan "$(nproc)" -L threads
    fi
    export COLLIDED_FUZZ_SEED=0
    if ready "build fuzz" build_for_night fuzz "" -DCOLLIDED_FUZZ_SECONDS="$seconds"; then
        phase "fuzzers, $seconds s each, from elsewhere" run_tests fuzz "$(nproc)" -L fuzz
    fi
    build_for_night fuzz "" -DCOLLIDED_FUZZ_SECONDS=15 >/dev/null 2>&1 || true # as script/test has it

    ready "benchmarks: no row 10 % slower than at the commit of tests/bench/baseline.json" script/bench --compare --name || true

    printf '%s\n' $unsteady | sort -u | sed "/^$/d; s/^/$(date +%F) /" >>"$nights/unsteady"
    script/night_page --nights "$nights" --limit "$limit" --broken "$broken" "${results[@]}" >"$tonight/page.txt" || held=1
    cat "$tonight/page.txt"
    say "this page: $tonight/page.txt"
    return $held
}
