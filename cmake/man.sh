#!/bin/sh
# man.sh COMMAND PAGE.in: the manual page, with what each command says of itself in place of @COMMANDS@.
set -e
sed -e "s/@VERSION@/$("$1" --version)/" -e '/^@COMMANDS@$/,$d' "$2"
"$1" help | sed -n 's/^  \([a-z]\{1,\}\) .*/\1/p' | while read -r name; do
    [ "$name" != help ] || continue
    text=$("$1" "$name" --help) || continue # a command of Python in a build without
    printf '.SS %s\n.nf\n' "$name"
    printf '%s\n' "$text" | sed -e '/^ *Common options:/,/rint the version/d' -e '/^Mandatory or optional/,/^for any/d' \
        -e 's/\\/\\e/g' -e 's/-/\\-/g' -e "s/^[.']/\\\\\\&&/"
    echo .fi
done
sed '1,/^@COMMANDS@$/d' "$2"
