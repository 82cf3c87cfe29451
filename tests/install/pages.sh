#!/usr/bin/env bash
# Checks the man pages and the completions of an installed tree. usage: pages.sh PREFIX
set -euo pipefail
prefix=$1

fail() { echo "pages: $1" >&2; exit 1; }

# Prints the words that bash offers for the last of the arguments.
offered() {
  COMP_WORDS=("$@")
  COMP_CWORD=$(($# - 1))
  COMPREPLY=()
  _cairn
  printf '%s\n' "${COMPREPLY[@]}" | sort -u | paste -sd' '
}

expect() {
  local expected=$1 found
  shift
  found=$(offered "$@")
  [ "$found" = "$expected" ] || fail "completion of '$*': expected '$expected', found '$found'"
}

. "$prefix/share/bash-completion/completions/cairn"
cd "$(mktemp -d)"
touch some.cairn
expect "bake" cairn ba
expect "verify view" cairn v
expect "--void --void-distance" cairn bake --vo
expect "fill keep" cairn bake --void ""
expect "compare" cairn lab co
expect "--screenshot" cairn view --scr
expect "--screenshot" cairn-view --scr
expect "some.cairn" cairn info so

for page in "$prefix"/share/man/man1/*.1; do
  grep -q '^\.SH NAME$' "$page" || fail "$page: expected a section NAME, found none"
  if command -v groff >/dev/null; then
    faults=$(groff -man -Tutf8 -ww -z "$page" 2>&1)
    [ -z "$faults" ] || fail "$page: expected no warnings of groff, found $faults"
    text=$(groff -man -Tascii -P-cbou "$page")
    [[ $text == *--help* ]] || fail "$page: expected the option --help, found none"
  fi
done
! command -v zsh >/dev/null || zsh -n "$prefix/share/zsh/vendor-completions/_cairn"
! command -v fish >/dev/null || fish -n "$prefix/share/fish/vendor_completions.d/cairn.fish"
