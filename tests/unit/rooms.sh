#!/bin/sh
# Public headers and sources of libbrick's rooms include only what their room may see. Argument: the source root.
# (Private headers are held to this by include folders; libraries among each other too.)
cd "$1/libbrick" || exit 1
base="error checked io threads"
volume="type grid transfer camera image mesh stats source"
codec="codec"
store="volume damaged writer"
build="build repair"
stream="active cache loader"
failed=0
check() { # room, allowed header names
    room=$1
    shift
    eval "own=\$$room"
    files=$(ls "$room"/*.c "$room"/*.h 2>/dev/null)
    for name in $own; do
        files="$files include/brick/$name.h"
    done
    for file in $files; do
        for header in $(sed -n 's/^#include [<"]brick\/\([a-z_]*\)\.h[>"].*/\1/p' "$file"); do
            case " $* " in
            *" $header "*) ;;
            *)
                echo "$file: includes brick/$header.h, which is above its room $room"
                failed=1
                ;;
            esac
        done
        if grep -nE '#include *[<"](GL|EGL|formats|renderer)/' "$file"; then
            echo "$file: libbrick reaches out of itself"
            failed=1
        fi
    done
}
check base $base
check volume $base $volume
check codec $base $volume $codec
check store $base $volume $codec $store
check build $base $volume $codec $store $build
check stream $base $volume $codec $store $stream
listed=$(echo $base $volume $codec $store $build $stream | wc -w)
found=$(ls include/brick/*.h | wc -l)
if [ "$listed" != "$found" ]; then
    echo "$found public headers, but $listed have a room here"
    failed=1
fi
exit $failed
