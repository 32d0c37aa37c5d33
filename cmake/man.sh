#!/bin/sh
# man.sh PAGE.in COMMAND...: the manual page, with what each command says of itself in place of @COMMANDS@.
set -e
page=$1
shift
sed -e "s/@VERSION@/$("$@" --version)/" -e '/^@COMMANDS@$/,$d' "$page"
"$@" help | sed -n 's/^  \([a-z]\{1,\}\) .*/\1/p' | while read -r name; do
    [ "$name" != help ] || continue
    text=$("$@" "$name" --help) || continue # a command of Python in a build without
    printf '.SS %s\n.nf\n' "$name"
    printf '%s\n' "$text" | sed -e '/^ *Common options:/,/rint the version/d' -e '/^Mandatory or optional/,/^for any/d' \
        -e 's/\\/\\e/g' -e 's/-/\\-/g' -e "s/^[.']/\\\\\\&&/"
    echo .fi
done
sed '1,/^@COMMANDS@$/d' "$page"
