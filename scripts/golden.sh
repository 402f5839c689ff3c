#!/usr/bin/env bash
# Writes the golden outputs of docs/golden anew; docs/golden/README.md says what each is. Look at the
# difference, and mend the pages that `cargo test --package hysteron-host --test book` names.
#   golden.sh                 what needs neither measured data, an emulator nor minutes
#   golden.sh data DATA       the mirror and the stack, from the folder of measured data
#   golden.sh emulator ELF    faults in the emulator, of a firmware built with the feature qemu
#   golden.sh counts          instructions in the emulator
#   golden.sh blind [NAME]... the blind trials, all or those named
# HYSTERON is the program and EXAMPLES the folder of the examples; by default both are built here.
set -euo pipefail
cd "$(dirname "$0")/.."

if [ -z "${HYSTERON:-}" ] && [ "${1:-}" != counts ]; then
    cargo build --quiet --release --locked --package hysteron-host --bins --examples
    HYSTERON=${CARGO_TARGET_DIR:-target}/release/hysteron
fi
examples=${EXAMPLES:-$(dirname "${HYSTERON:-}")/examples}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# FILE NAME [KEY]...: as docs/golden/NAME.json, without these keys.
keep() { "$examples/golden" "$1" "docs/golden/$2.json" "${@:3}"; }

# NAME DATA [OPTION]...: a diagnosis.
diagnosis() {
    "$HYSTERON" diagnose "${@:2}" --out "$work/$1" >/dev/null
    keep "$work/$1/diagnosis.json" "$1" notes
}

# NAME OPTION...: blind trials; their single cases and processor times go.
trials() {
    "$HYSTERON" blind "${@:2}" --out "$work/$1" >/dev/null
    keep "$work/$1/blind.json" "$1" cases: scores:seconds scores:interval scores:rate
}

# NAME OPTION...: a campaign of faults.
campaign() {
    "$HYSTERON" faults "${@:2}" --out "$work/$1" >/dev/null
    keep "$work/$1/faults.json" "$1"
}

case ${1:-} in
'')
    "$HYSTERON" experiment j --out "$work/j" >/dev/null
    keep "$work/j/j.json" j
    # Fittings stay in the studies; harmonic terms are checked against their expansions.
    "$HYSTERON" experiment m --out "$work/m" >/dev/null
    keep "$work/m/m.json" m harmonic_terms frequencies:fitting_percent frequencies:model_rms_error_mm \
        frequencies:saturated frequencies:refused
    "$HYSTERON" experiment beyond --out "$work/beyond" >/dev/null
    keep "$work/beyond/beyond.json" beyond reason {sweep,feedback}:{largest_um,largest_percent,rms_percent} \
        sweep:status against_dim:leap
    campaign faults
    campaign faults-1000 --runs 1000 --seed 10000
    for letter in j m; do
        "$examples/worked_examples" "paper-$letter" "$work/paper-$letter"
        diagnosis "found-$letter" "$work/paper-$letter" --baseline pi
    done
    ;;
data)
    "$examples/mirror" "$2/fast-steering-mirror" "$work/mirror" >/dev/null
    for axis in 1 2 3; do
        for kind in mixed own; do
            diagnosis "found-$kind-$axis" "$work/mirror/$kind-$axis"
        done
    done
    diagnosis found-stack "$2/piezo-stack-1hz"
    ;;
emulator) campaign faults-emulator --runs 4 --firmware "$2" ;;
counts)
    scripts/bench-firmware.sh >docs/golden/bench-firmware.txt
    scripts/count-bank-instructions.sh >docs/golden/bank-on-m4f.txt
    ;;
blind)
    shift
    [ $# -gt 0 ] || set -- tier{1,2,3,4} none{1,2,3,4} pairs triples
    for name; do
        case $name in
        tier4) options=(--cases 80 --tier 4 --seed 12101) ;;
        tier?) options=(--cases 80 --tier "${name#tier}" --seed 12001) ;;
        none?) options=(--cases 300 --tier "${name#none}" --none-share 1 --seed "9${name#none}000") ;;
        pairs) options=(--cases 40 --tier 1 --effects 2 --none-share 0 --seed 12201) ;;
        triples) options=(--cases 40 --tier 1 --effects 3 --none-share 0 --seed 12301) ;;
        *) echo "no blind trials $name" >&2 && exit 2 ;;
        esac
        trials "blind-$name" "${options[@]}"
    done
    ;;
*) echo "golden.sh [data DATA | emulator ELF | counts | blind [NAME]...]" >&2 && exit 2 ;;
esac
