#!/usr/bin/env bash
# Makes the Debian packages of a build, inspects them, and installs and removes them in a tree of their own.
# usage: deb.sh SOURCE BUILD
set -euo pipefail
source=$1 build=$2

fail() { echo "deb: $1" >&2; exit 1; }

if ! command -v dpkg-deb >/dev/null || ! command -v dpkg-shlibdeps >/dev/null; then
  echo "SKIPPED: dpkg-deb or dpkg-shlibdeps (dpkg-dev) is not installed"
  exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$build" && cpack -G DEB -B "$work" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip >"$work/log" 2>&1) || fail "$(cat "$work/log")"
programs=$(echo "$work"/cairn_*.deb)
libraries=$(echo "$work"/libcairn-dev_*.deb)
[ -f "$programs" ] && [ -f "$libraries" ] || fail "expected the packages cairn and libcairn-dev, found $(ls "$work")"

depends=$(dpkg-deb -f "$programs" Depends)
for library in libc6 libtiff6 libzstd1 libgeographic; do
  [[ $depends == *$library* ]] || fail "cairn: expected to depend on $library, found $depends"
done
contents=$(dpkg-deb -c "$programs")
for file in bin/cairn bin/cairn-view bin/cairn-stats bin/cairn-lab share/man/man1/cairn-bake.1 share/mime/packages/cairn.xml \
            share/applications/cairn-view.desktop share/doc/cairn/copyright; do
  grep -q " ./usr/$file\$" <<<"$contents" || fail "cairn: expected /usr/$file, found none"
done
! grep -q "/include/" <<<"$contents" || fail "cairn: expected no headers, found some"
contents=$(dpkg-deb -c "$libraries")
grep -q ' ./usr/include/cairn/terrain.h$' <<<"$contents" || fail "libcairn-dev: expected headers, found none"
packages=("$programs" "$libraries")
module=$(echo "$work"/python3-cairn_*.deb)
if [ -f "$module" ]; then
  packages+=("$module")
  grep -q ' ./usr/lib/python3/dist-packages/cairn/_cairn' <<<"$(dpkg-deb -c "$module")" || fail "python3-cairn: expected the module, found none"
fi

# A tree with an empty dpkg database, so that the machine's own stays as it is.
root=$work/root
mkdir -p "$root/var/lib/dpkg/updates" "$root/var/lib/dpkg/info"
touch "$root/var/lib/dpkg/status"
in_root=(dpkg --root="$root" --force-not-root --force-depends --force-script-chrootless --log=/dev/null)
"${in_root[@]}" -i "${packages[@]}" >"$work/log" 2>&1 || fail "install: $(cat "$work/log")"
"$root/usr/bin/cairn" bake "$source/sample-dem/jacksboro_fault.tif" -o "$work/sample.cairn" --threads 1 >/dev/null
"$root/usr/bin/cairn" info "$work/sample.cairn" >/dev/null
for verb in view stats lab; do "$root/usr/bin/cairn" $verb --help >/dev/null; done
if [ -f "$module" ]; then
  PYTHONPATH=$root/usr/lib/python3/dist-packages /usr/bin/python3 -B -c \
    "import sys, cairn; print(cairn.open(sys.argv[1]).heights(-84.2, 36.6).metres)" "$work/sample.cairn" >/dev/null
fi
names=()
for package in "${packages[@]}"; do names+=("$(dpkg-deb -f "$package" Package)"); done
"${in_root[@]}" -P "${names[@]}" >"$work/log" 2>&1 || fail "remove: $(cat "$work/log")"
left=$(find "$root" -path "$root/var" -prune -o -type f -print)
[ -z "$left" ] || fail "remove: expected nothing left, found $left"
