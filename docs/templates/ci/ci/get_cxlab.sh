#!/bin/sh
# Gets the tarball that ci/cxlab.txt names, checks that it is that one, and unpacks it into .cxlab. Debian 12 or newer, x86_64.
set -eu
cd "$(dirname "$0")/.."

fail() {
  echo "ci/cxlab.txt: $1" >&2
  exit 1
}

value_of() { sed -n "s/^$1[[:space:]]*//p" ci/cxlab.txt | sed 's/[[:space:]]*$//'; }

address=$(value_of address)
sha256=$(value_of sha256)
[ -n "$address" ] || fail "there is no address: write where the tarball of cxlab lies"
[ -n "$sha256" ] || fail "there is no sha256: write what sha256sum prints for the tarball"
[ "$(cat .cxlab/sha256 2>/dev/null || true)" != "$sha256" ] || exit 0

rm -rf .cxlab
mkdir .cxlab
case $address in
  http://* | https://*)
    if ! command -v curl >/dev/null; then
      apt-get update -q
      apt-get install -q -y --no-install-recommends ca-certificates curl
    fi
    curl --fail --location --silent --show-error --retry 3 --output .cxlab/tarball "$address" ||
      fail "the tarball cannot be fetched from $address"
    ;;
  *) cp "$address" .cxlab/tarball || fail "the tarball $address cannot be read" ;;
esac
found=$(sha256sum .cxlab/tarball | cut -d ' ' -f 1)
[ "$found" = "$sha256" ] || fail "the file at $address has the sha256 $found, expected $sha256"
tar xzf .cxlab/tarball -C .cxlab --strip-components=1
rm .cxlab/tarball
.cxlab/bin/cxlab --version
echo "$sha256" >.cxlab/sha256
