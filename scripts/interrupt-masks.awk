# Finds what keeps the sample interrupt waiting in the output of `objdump -d --no-show-raw-insn -C`: see
# check-firmware.sh. It has the highest priority, so only a mask can.
#
# Masks are for the start, before there are samples, and for the end, when there are to be none. Between
# them a stretch must be short and straight: no call, no jump back. Giving BASEPRI back the value that it
# had, as RTIC does around a task, masks nothing.

/^[0-9a-f]+ <.*>:$/ {
    if (masked) fail("is never unmasked")
    name = substr($0, index($0, "<") + 1)
    sub(/>:$/, "", name)
    start_or_end = name ~ /^(main|DefaultHandler|.*__rtic_init_resources.*|.*rust_begin_unwind)$/
    masked = 0
    delete held
    if (name ~ /serial::Line>?::run/) loops++
    next
}

/^ *[0-9a-f]+:/ {
    operation = $2
    if (masked) {
        stretch++
        if (operation ~ /^bl/) fail("calls while masked")
        else if (operation ~ /^(b|cb)/ && /</) fail("jumps while masked")
    }
    if (operation == "mrs" && $4 ~ /^BASEPRI/) { register = $3; sub(/,/, "", register); held[register] = 1 }
    if (start_or_end) next
    if (operation == "cpsid") { masked = 1; stretch = 0 }
    else if (operation == "cpsie") { end_of_stretch() }
    else if (operation == "msr" && $3 ~ /^(BASEPRI|PRIMASK|FAULTMASK)/) {
        if ($3 != "BASEPRI," || !($4 in held)) fail("writes " $3 " " $4)
    }
}

function fail(why) { print name ": " why; failed = 1; masked = 0 }

function end_of_stretch() {
    # The unmasking itself is none of it.
    if (masked && stretch - 1 > longest) { longest = stretch - 1; where = name }
    masked = 0
}

END {
    # Inlined into the start it would go unseen.
    if (!loops) { print "there is no serial::Line::run"; failed = 1 }
    if (longest > 64) { print where ": " longest " instructions masked"; failed = 1 }
    if (failed) exit 1
    if (longest) printf "masked: %d instructions at most, in %s\n", longest, where
    else print "masked: never between start and end"
}
