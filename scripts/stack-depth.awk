# Bounds the stack from the output of `objdump -d --no-show-raw-insn -C`: the deepest path of calls
# from Reset, interrupted at its end by USART1, that by TIM3, and that by a fault; see
# check-firmware.sh.
#
# What a function takes is the sum of all its pushes, wherever in it they are. A call through a register
# is one of the store behind the link or an error; so is recursion, and a frame of a size that is only
# known when it runs.

# What the core pushes for an exception: 8 registers, 18 of floats, a word to align.
BEGIN { exception = 4 * (8 + 18 + 1) }

/^[0-9a-f]+ <.*>:$/ {
    at = $1
    sub(/^0+/, "", at)
    name[at] = substr($0, index($0, "<") + 1)
    sub(/>:$/, "", name[at])
    of_name[name[at]] = at
    frame[at] = 0
    next
}

/^ *[0-9a-f]+:/ {
    operation = $2
    operands = $0
    sub(/^[^\t]*\t[^\t]*\t?/, "", operands)
    if (operation ~ /^v?push|^v?stmdb/ && (operation ~ /push/ || operands ~ /^sp!/)) {
        frame[at] += registers(operands)
    } else if (operation ~ /^sub/ && operands ~ /^sp, /) {
        if (match(operands, /#[0-9]+/)) frame[at] += substr(operands, RSTART + 1, RLENGTH - 1)
        else fail("a frame of unknown size in " name[at])
    } else if (match(operands, /\[sp, #-[0-9]+\]!/)) {
        frame[at] += substr(operands, RSTART + 7, RLENGTH - 9)
    } else if (operation ~ /^blx/ && operands ~ /^r/ || operation ~ /^bx/ && operands !~ /^lr/) {
        if (name[at] ~ /link::server::Server>::(save|kept)$/) through_store[at] = 1
        else fail("a call through a register in " name[at])
    } else if (operation ~ /^(b|cb)/ && match(operands, /[0-9a-f]+ </)) {
        target = substr(operands, RSTART, RLENGTH - 2)
        if (target != at) calls[at] = calls[at] " " target
    }
}

function fail(why) { print why; failed = 1 }

# Bytes of a list of registers, `{r4, r5, lr}` or `{d8-d11}`.
function registers(list, parts, n, i, ends, bytes) {
    sub(/^[^{]*\{/, "", list)
    sub(/\}.*/, "", list)
    n = split(list, parts, /, */)
    for (i = 1; i <= n; i++) {
        bytes = parts[i] ~ /^d/ ? 8 : 4
        if (split(parts[i], ends, "-") == 2) bytes *= substr(ends[2], 2) - substr(ends[1], 2) + 1
        total[list] += bytes
    }
    bytes = total[list]
    delete total[list]
    return bytes
}

function depth(of, targets, n, i, deepest, here) {
    if (of in known) return known[of]
    if (of in open_) { fail("recursion through " name[of]); return 0 }
    open_[of] = 1
    if (of in through_store)
        for (i in name)
            if (name[i] ~ /as hysteron::store::Keep>::/) calls[of] = calls[of] " " i
    n = split(calls[of], targets, " ")
    deepest = 0
    for (i = 1; i <= n; i++) {
        if (!(targets[i] in name)) continue
        here = depth(targets[i])
        if (here > deepest) { deepest = here; deepest_of[of] = targets[i] }
    }
    delete open_[of]
    return known[of] = frame[of] + deepest
}

function of(root) {
    if (!(root in of_name)) { fail("there is no " root); return 0 }
    return depth(of_name[root])
}

function path(from, text) {
    for (text = ""; from != ""; from = deepest_of[from])
        if (frame[from] >= 256) text = text sprintf("%s%s %d", text == "" ? "" : " -> ", name[from], frame[from])
    return text
}

END {
    thread = of("Reset"); port = of("USART1"); sample = of("TIM3")
    fault = of("HardFault"); other = of("DefaultHandler")
    if (other > fault) fault = other
    bound = thread + port + sample + fault + 3 * exception
    if (failed) exit 1
    printf "stack by the calls: %d bytes: %d in %s; %d more in USART1, %d in TIM3, %d in a fault, %d on their ways\n", \
        bound, thread, path(of_name["Reset"]), port, sample, fault, 3 * exception
}
