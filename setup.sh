#!/usr/bin/env bash
# Installs what étendue needs to build on Debian 12 or 13: a C compiler, pkg-config, libclang, Embree 4 and, where
# no cargo of the minimum version exists, a Rust toolchain. Safe to run again: it changes nothing that is in place.
#
#   EMBREE_DIR=/path   use that Embree 4 installation (its include/ and lib/) and install none
#   ETENDUE_NO_EMBREE=1  skip Embree and libclang (for builds with --no-default-features)
set -euo pipefail
cd "$(dirname "$0")"

msrv=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
say() { printf 'setup: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }
at_least() { [ "$(printf '%s\n%s\n' "$2" "$1" | sort -V | head -n 1)" = "$2" ]; }
have_package() { dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null | grep -qx installed; }

updated=
apt_update() { [ -n "$updated" ] || { as_root apt-get update -q; updated=1; }; }
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else die "this needs root (or sudo): $*"; fi
}
apt_install() { apt_update; as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@"; }
need_packages() {
  local missing=() p
  for p in "$@"; do have_package "$p" || missing+=("$p"); done
  [ ${#missing[@]} = 0 ] || { say "installing ${missing[*]}"; apt_install "${missing[@]}"; }
}

# --- which Debian -----------------------------------------------------------------------------------------------
. /etc/os-release
case "${ID:-}:${VERSION_ID:-}" in
  debian:12|debian:13) ;;
  *) say "this is ${PRETTY_NAME:-an unknown system}, tested are Debian 12 and 13; install Embree >= 4.3, libclang and pkg-config by hand (EMBREE_DIR names Embree's folder)" ;;
esac

# --- the address of Debian's mirror and its keyring, from the machine's own sources ---------------------------------
debian_source() { # prints "URI KEYRING" of the first source that serves this release's main archive
  awk -v codename="${VERSION_CODENAME:-}" '
    function flush() { if (uri != "" && (" " suites " ") ~ (" " codename " ")) { print uri, key; found = 1; exit } uri = key = suites = "" }
    FILENAME ~ /\.sources$/ { if ($0 ~ /^[ \t]*$/ || FNR == 1) flush()
      if ($1 == "URIs:") uri = $2; if ($1 == "Signed-By:") key = $2
      if ($1 == "Suites:") { suites = $0; sub(/^Suites:[ \t]*/, "", suites) } next }
    $1 == "deb" { line = $0; sub(/^deb[ \t]+/, "", line); key = ""
      if (match(line, /^\[[^]]*\][ \t]*/)) { options = substr(line, 1, RLENGTH); line = substr(line, RLENGTH + 1)
        if (match(options, /signed-by=[^] \t]*/)) key = substr(options, RSTART + 10, RLENGTH - 10) }
      split(line, f, /[ \t]+/); if (f[2] == codename) { print f[1], key; found = 1; exit } }
    END { if (!found) flush() }
  ' $(ls /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list /etc/apt/sources.list 2>/dev/null)
}

embree_from_trixie() {
  local uri key
  read -r uri key < <(debian_source) || true
  [ -n "${uri:-}" ] || die "no source for Debian's main archive found under /etc/apt, so Embree 4 cannot be found; set EMBREE_DIR"
  [ -n "${key:-}" ] || key=/usr/share/keyrings/debian-archive-keyring.gpg
  say "Debian 12 has Embree 3 only. Adding Debian 13 (trixie) as a second source, pinned to priority 50 so that nothing"
  say "moves to it by itself, and installing libembree-dev from there. That upgrades libc6 and about 30 packages it needs; none is removed."
  as_root tee /etc/apt/sources.list.d/etendue-trixie.sources >/dev/null <<SOURCE
Types: deb
URIs: $uri
Suites: trixie
Components: main
Signed-By: $key
SOURCE
  as_root tee /etc/apt/preferences.d/etendue-trixie >/dev/null <<'PIN'
Explanation: only what is asked for by name (-t trixie) comes from Debian 13
Package: *
Pin: release n=trixie
Pin-Priority: 50
PIN
  updated=
  apt_install -t trixie libembree-dev
}

# --- packages -----------------------------------------------------------------------------------------------------
need_packages gcc libc6-dev pkg-config make ca-certificates
if [ -z "${ETENDUE_NO_EMBREE:-}" ]; then
  need_packages libclang-dev
  if [ -n "${EMBREE_DIR:-}" ]; then
    [ -f "$EMBREE_DIR/include/embree4/rtcore.h" ] || die "EMBREE_DIR=$EMBREE_DIR holds no include/embree4/rtcore.h"
  elif ! pkg-config --exists 'embree4 >= 4.3' 2>/dev/null && ! [ -f /usr/include/embree4/rtcore.h ]; then
    apt_update
    if apt-cache policy libembree-dev | grep -q 'Candidate: 4'; then apt_install libembree-dev; else embree_from_trixie; fi
  fi
fi

# --- Rust ---------------------------------------------------------------------------------------------------------
cargo_version() { cargo --version 2>/dev/null | awk '{print $2}'; }
if ! command -v cargo >/dev/null; then
  [ "${VERSION_ID:-}" = 12 ] && die "no cargo found, and Debian 12's is older than $msrv: install a toolchain >= $msrv with rustup"
  say "no cargo found: installing Debian's"
  apt_install cargo rustc
fi
at_least "$(cargo_version)" "$msrv" || die "cargo $(cargo_version) is older than the minimum, $msrv: update the toolchain (rustup update stable)"
