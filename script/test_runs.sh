# test_runs.sh: how script/test runs tests. Sourced, after common.sh.
# shellcheck shell=bash

export ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1:abort_on_error=0
export UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$root/tests/lsan.supp:print_suppressions=0
export TSAN_OPTIONS=suppressions=$root/tests/tsan.supp:second_deadlock_stack=1

unsteady= # tests of this run that passed only when they were run once more, alone
building= # the build in the background

# The end is what remains of a long log: what is unsteady is told there, whether the run passes or not.
at_end() {
    local status=$?
    [ -z "$building" ] || wait "$building" || true
    [ -n "$unsteady" ] || exit "$status"
    say ""
    say "########################################################################"
    say "##  UNSTEADY: these tests FAILED, and passed only when run once more,"
    say "##  alone. Each is a fault of the test or of the program: mend it."
    say "##"
    printf '##    %s\n' $unsteady >&2
    say "########################################################################"
    exit "$status"
}

run_tests() { # run_tests PRESET PLACES [ctest options...]: so many tests at a time
    local preset=$1 places=$2 status=0
    shift 2
    say "testing $preset: $*"
    ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$places" "$@" || status=$?
    grep '^skipped' "build/$preset/Testing/Temporary/LastTest.log" | sort -u >&2 || true
    [ $status = 0 ] || tell_failures "build/$preset/Testing/Temporary" >&2
    return $status
}

# Tests of processes wait for conditions, but the machine may be busier than they are patient: what failed runs once more
# alone, and is named as unsteady if it passes then.
run_again() { # run_again PRESET [ctest options...]
    local failed="build/$1/Testing/Temporary/LastTestsFailed.log" names preset=$1
    shift
    [ -s "$failed" ] || return 1
    names=$(cut -d: -f2 "$failed" | sort -u | tr '\n' ' ')
    say "once more, alone: $names"
    ctest --test-dir "build/$preset" --output-on-failure --no-tests=error --rerun-failed -j 1 "$@" || return 1
    for name in $names; do unsteady+="$name($preset) "; done
}

# Of each test that failed, the lines that say why.
tell_failures() { # tell_failures FOLDER_OF_LOGS
    local name
    cut -d: -f2 "$1/LastTestsFailed.log" | while read -r name; do
        say "$name failed:"
        awk -v name="$name" '
            $2 == "Testing:" { ours = $3 == name }
            ours && /ERROR|FAILED|SUMMARY|broken:|runtime error|[Ff]ailure|error:|assert|Traceback/ && ++lines <= 12
        ' "$1/LastTest.log" | cut -c1-1500
    done
}

# Tests of processes in a network of their own wait most of the time: many at once, and beside them the next builds, which
# take what they leave of the processors.
of_processes='^(network|startup)$'
compute() { run_tests "$1" "$(nproc)" -LE "$of_processes" "${@:2}"; }
talk() { run_tests "$1" $((3 * $(nproc))) -L "$of_processes" "${@:2}" || run_again "$1"; }
# What a build with sanitizers says no more about than the release does: pages, scripts, pictures, what a browser shows,
# and storms of one kind, of which storm_all is all at once. The night runs these there, too.
of_release='^(manual.*|test_layer_.*|test_make_site|test_scene_page|picture|test_readme|web_.*|doctor_.*|demo_.*_lcm|storm|storm_pair|storm_network|test_closed_site|bench_.*_security_smoke)$'
begin_build() { # begin_build PRESET...: in the background; end_build waits for it
    (
        trap - EXIT
        renice -n 19 "$BASHPID" >/dev/null
        for preset in "$@"; do build "$preset"; done
    ) &
    building=$!
}
end_build() {
    local status=0
    wait "$building" || status=$?
    building=
    return $status
}
