#!/usr/bin/env bash
# Installs what étendue needs to build and test on Debian 12 or 13: a C compiler, pkg-config, libclang, Embree 4, Python 3
# (for the scene scripts) and, where no cargo of the minimum version exists, Debian's Rust toolchain. Safe to run again: it
# changes nothing that is in place. Elsewhere it installs nothing and says what is missing.
#
#   EMBREE_DIR=/path     use that Embree 4 installation (its include/ and lib/) and install none
#   ETENDUE_BROWSER=1    install Chromium too, which the test of the report pages drives
#   ETENDUE_NO_EMBREE=1  skip Embree and libclang (for builds with --no-default-features)
set -euo pipefail
cd "$(dirname "$0")"
PATH=$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin # where rustup puts cargo, if the shell does not know it yet

msrv=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
say() { printf 'setup: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }
have() { command -v "$1" >/dev/null; }
at_least() { [ "$(printf '%s\n%s\n' "$2" "$1" | sort -V | head -n 1)" = "$2" ]; }

# --- apt ----------------------------------------------------------------------------------------------------------
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif have sudo; then sudo "$@"
  else die "this needs root (or sudo): $*"; fi
}
updated=
apt_update() { [ -n "$updated" ] || { as_root apt-get update -q; updated=1; }; }
apt_install() {
  apt_update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@"
}
installed() { dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null | grep -x installed >/dev/null; }
candidate() { apt-cache policy "$1" | awk '$1 == "Candidate:" { sub(/^[0-9]+:/, "", $2); print $2 }'; }
need_packages() {
  local missing=() p
  for p in "$@"; do installed "$p" || missing+=("$p"); done
  [ ${#missing[@]} = 0 ] || { say "installing ${missing[*]}"; apt_install "${missing[@]}"; }
}

# Prints "URI KEYRING" of the first source under /etc/apt that serves the main archive of Debian `$1`.
debian_source() {
  local files=() f
  for f in /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list /etc/apt/sources.list; do
    [ ! -f "$f" ] || files+=("$f")
  done
  [ ${#files[@]} = 0 ] || awk -v codename="$1" '
    function flush() { # a whole deb822 paragraph has been read
      if (uri != "" && on && (" " suites " ") ~ (" " codename " ")) { print uri, key; found = 1; exit }
      uri = key = suites = ""; on = 1
    }
    BEGIN { on = 1 }
    FNR == 1 { flush() }
    FILENAME ~ /\.sources$/ {
      if ($0 ~ /^[ \t]*$/) flush()
      else if ($1 == "URIs:") uri = $2
      else if ($1 == "Signed-By:") key = $2
      else if ($1 == "Enabled:") on = ($2 != "no")
      else if ($1 == "Types:") on = (" " $0 " ") ~ / deb /
      else if ($1 == "Suites:") { suites = $0; sub(/^Suites:[ \t]*/, "", suites) }
      next
    }
    $1 == "deb" {
      line = $0; sub(/^[ \t]*deb[ \t]+/, "", line); key = ""
      if (match(line, /^\[[^]]*\][ \t]*/)) {
        options = substr(line, 1, RLENGTH); line = substr(line, RLENGTH + 1)
        if (match(options, /signed-by=[^] \t]*/)) key = substr(options, RSTART + 10, RLENGTH - 10)
      }
      split(line, field, /[ \t]+/)
      if (field[2] == codename) { print field[1], key; found = 1; exit }
    }
    END { if (!found) flush() }
  ' "${files[@]}"
}

# Debian 12's archive has Embree 3 and cargo 0.66 only: makes Debian 13's available by name, and by name only.
add_trixie() {
  [ -n "$(debian_source trixie)" ] && return
  local uri key
  read -r uri key <<<"$(debian_source bookworm)" || true
  [ -n "${uri:-}" ] || die "no source for Debian 12's main archive found under /etc/apt, so Debian 13's packages cannot be reached; set EMBREE_DIR and install Rust >= $msrv with rustup"
  case "${key:-}" in /*) ;; *) key=/usr/share/keyrings/debian-archive-keyring.gpg ;; esac
  say "adding Debian 13 (trixie) as a second source from the same mirror, pinned to priority 50 so that nothing moves to it by itself:"
  say "/etc/apt/sources.list.d/etendue-trixie.sources and /etc/apt/preferences.d/etendue-trixie"
  as_root tee /etc/apt/preferences.d/etendue-trixie >/dev/null <<'PIN'
Explanation: only what is asked for by name (-t trixie) comes from Debian 13
Package: *
Pin: release n=trixie
Pin-Priority: 50
PIN
  as_root tee /etc/apt/sources.list.d/etendue-trixie.sources >/dev/null <<SOURCE
Types: deb
URIs: $uri
Suites: trixie
Components: main
Signed-By: $key
SOURCE
  updated=
}

# Installs packages from Debian 13. Its libraries replace some of Debian 12's under a new name (libssl3 by libssl3t64, say);
# anything else that would be removed by it stops the script.
install_from_trixie() {
  local plan lost
  add_trixie
  apt_update
  plan=$(apt-get -s install --no-install-recommends -t trixie "$@") || die "apt cannot install $* from Debian 13: $plan"
  lost=$(awk '$1 == "Inst" { new[$2] } $1 == "Remv" { gone[$2] }
    END { for (p in gone) if (!((p "t64") in new)) print p }' <<<"$plan" | sort | xargs)
  [ -z "$lost" ] || die "installing $* from Debian 13 would remove $lost: install Embree 4 (EMBREE_DIR) and Rust >= $msrv (rustup) by hand"
  say "installing $* from Debian 13, libc6 and what else they need included: $(grep -E '^[0-9]+ upgraded' <<<"$plan")"
  apt_install -t trixie "$@"
}

# Installs the packages after the version from this release if its `$2` is at least `$1`, else from Debian 13.
# (What is installed decides and not VERSION_ID: a package from Debian 13 may have brought 13's /etc/os-release along.)
install_at_least() {
  local version=$1 first=$2
  shift
  apt_update
  if at_least "$(candidate "$first")" "$version"; then
    say "installing $*"
    apt_install "$@"
  else
    install_from_trixie "$@"
  fi
}

# --- what is needed -----------------------------------------------------------------------------------------------
use_apt=
# shellcheck source=/dev/null
. /etc/os-release
case "${ID:-}:${VERSION_ID:-}" in
  debian:12 | debian:13) use_apt=1 ;;
  *) say "this is ${PRETTY_NAME:-an unknown system}, tested are Debian 12 and 13: installing nothing; needed are a C compiler, pkg-config, libclang, Embree >= 4.3 (EMBREE_DIR names its folder) and Rust >= $msrv" ;;
esac

embree_header() { # the header that the build will find, or nothing
  local dir
  for dir in ${EMBREE_DIR:+"$EMBREE_DIR/include"} /usr/include /usr/local/include; do
    [ ! -f "$dir/embree4/rtcore.h" ] || { echo "$dir/embree4/rtcore.h"; return; }
    [ -z "${EMBREE_DIR:-}" ] || return 0
  done
}

if [ -n "$use_apt" ]; then
  need_packages gcc libc6-dev make pkg-config ca-certificates
  have python3 || need_packages python3
  [ -n "${ETENDUE_NO_EMBREE:-}" ] || need_packages libclang-dev
  [ -z "${ETENDUE_BROWSER:-}" ] || have chromium || need_packages chromium fonts-dejavu-core
fi

if [ -z "${ETENDUE_NO_EMBREE:-}" ]; then
  if [ -n "${EMBREE_DIR:-}" ]; then
    [ -n "$(embree_header)" ] || die "EMBREE_DIR=$EMBREE_DIR holds no include/embree4/rtcore.h"
  elif [ -z "$(embree_header)" ]; then
    [ -n "$use_apt" ] || die "Embree 4 not found: install it, or set EMBREE_DIR to its folder"
    install_at_least 4.3 libembree-dev
  fi
fi

# --- Rust ---------------------------------------------------------------------------------------------------------
cargo_version() { cargo --version 2>/dev/null | awk '{ print $2 }'; }
rust_packages=(rustc cargo rust-clippy rustfmt)
if ! have cargo; then
  [ -n "$use_apt" ] || die "no cargo found: install Rust >= $msrv"
  install_at_least "$msrv" "${rust_packages[@]}"
elif ! at_least "$(cargo_version)" "$msrv" && [ -n "$use_apt" ] && [ "$(command -v cargo)" = /usr/bin/cargo ]; then
  install_at_least "$msrv" "${rust_packages[@]}"
fi
hash -r
version=$(cargo_version)
[ -n "$version" ] || die "$(command -v cargo) does not run: with rustup, 'rustup default stable' gives it a toolchain"
at_least "$version" "$msrv" || die "cargo $version ($(command -v cargo)) is older than the minimum, $msrv: update the toolchain (with rustup: rustup update stable)"
for component in clippy fmt; do # `make test` uses both
  cargo "$component" --version >/dev/null 2>&1 && continue
  if have rustup; then rustup component add clippy rustfmt
  elif [ -n "$use_apt" ] && [ "$(command -v cargo)" = /usr/bin/cargo ]; then install_at_least "$msrv" rustc rust-clippy rustfmt
  else say "no cargo $component: \`make test\` will want it"; fi
done
