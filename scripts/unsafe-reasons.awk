# Reads Rust sources: `unsafe` only in src/board and in the benchmark that calls C, each block with its
# reason right above. Clippy says the same of what is compiled for the host; this sees the target's.

FNR == 1 { reason_at = -10 }

# The reason may stand above the statement that the block is in.
/\/\/ SAFETY: / { reason_at = FNR }

{
    code = $0
    sub(/\/\/.*/, "", code)
    gsub(/"[^"]*"/, "", code)
    if (code !~ /(^|[^a-z_])unsafe([^a-z_]|$)/) next
    if (FILENAME !~ /src\/(board|bin)\//) { print FILENAME ":" FNR ": unsafe outside of src/board"; bad = 1 }
    if (code ~ /unsafe *(\{|impl)/) {
        blocks++
        if (FNR - reason_at > 8) { print FILENAME ":" FNR ": unsafe without a reason"; bad = 1 }
    }
}

END {
    if (!bad) printf "unsafe: %d blocks, each with its reason, none outside of src/board but for a benchmark\n", blocks
    exit bad
}
