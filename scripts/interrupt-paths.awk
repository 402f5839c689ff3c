# Follows every call and jump from the sample interrupt in the output of
# `objdump -d --no-show-raw-insn -C` and says what it finds; see check-firmware.sh.
#
# A path to a panic, a trap, a call through a register, a division, a square root, or arithmetic in
# software is an error.

/^[0-9a-f]+ <.*>:$/ {
    name = $0
    sub(/^[0-9a-f]+ </, "", name)
    sub(/>:$/, "", name)
    next
}

/^ *[0-9a-f]+:/ {
    operation = $2
    if (operation ~ /^(udiv|sdiv|vdiv|vsqrt)/) divisions[name]++
    if (operation ~ /^(udf|bkpt)/) traps[name]++
    if (operation ~ /^blx/ && $3 ~ /^r/) indirect[name]++
    if (operation ~ /^(b|cb)/ && match($0, /<[^+]*>$/)) {
        target = substr($0, RSTART + 1, RLENGTH - 2)
        if (target != name && !((name, target) in seen)) {
            seen[name, target] = 1
            calls[name] = calls[name] target "\n"
        }
    }
}

END {
    if (!("TIM3" in calls)) { print "there is no TIM3 handler that calls anything"; exit 1 }
    todo = "TIM3\n"
    reached["TIM3"] = "TIM3"
    while (todo != "") {
        split(todo, queue, "\n")
        todo = ""
        for (q in queue) {
            if (queue[q] == "") continue
            split(calls[queue[q]], next_ones, "\n")
            for (i in next_ones) {
                target = next_ones[i]
                if (target == "" || target in reached) continue
                reached[target] = reached[queue[q]] " -> " target
                todo = todo target "\n"
            }
        }
    }
    bad = 0
    for (name in reached) {
        count++
        if (name ~ /panic|unwrap_failed|expect_failed|rust_begin_unwind|slice_.*_fail/) {
            print "panic: " reached[name]; bad = 1
        }
        if (name ~ /__aeabi_[dfl]|__.*[sd]f[23]$|libm/) {
            print "software arithmetic: " reached[name]; bad = 1
        }
        if (name in traps) { print "trap: " reached[name]; bad = 1 }
        if (name in indirect) { print "call through a register: " reached[name]; bad = 1 }
        if (name in divisions) { print "division: " reached[name]; bad = 1 }
    }
    if (!bad) printf "interrupt: %d functions, no panic, no trap, no division\n", count
    exit bad
}
