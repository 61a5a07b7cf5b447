#!/bin/sh
# Links for arm64 macOS without a Mac: drops those of rustc's arguments that zig's linker does not know, adds the folder of
# stand-ins for Apple's frameworks, and keeps the list of the symbols that are to be exported, which it does not heed.
count=$#
while [ "$count" -gt 0 ]; do
    argument=$1
    shift
    count=$((count - 1))
    case $argument in
    -arch)
        shift
        count=$((count - 1))
        ;;
    -mmacosx-version-min=* | -Wl,-dead_strip) ;;
    -Wl,-exported_symbols_list)
        cp "${1#-Wl,}" "$DRR_EXPORTS"
        shift
        count=$((count - 1))
        ;;
    *) set -- "$@" "$argument" ;;
    esac
done
exec $DRR_ZIG cc -target aarch64-macos.13.0 "-F$DRR_STUBS" "-L$DRR_STUBS" "$@" -Wl,-undefined,dynamic_lookup
