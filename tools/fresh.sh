#!/usr/bin/env bash
# Runs a command on a copy of the checkout in a fresh Debian 12 with only git and ca-certificates. The
# command installs the rest (tools/setup.sh installs tools/packages.txt). Proves that the set-up is complete. Needs root, mmdebstrap, a Debian mirror and about 6 GB of disk.
#
# Usage: tools/fresh.sh [--root DIR] COMMAND [ARGUMENT...]
#   --root DIR   keep the root in DIR (default: a temporary root). The next call copies the checkout's
#                changes into it and reuses its packages and builds
#
#   tools/fresh.sh tools/demo.sh
#   tools/fresh.sh tools/test.sh
#
# The copy has every tracked file and every untracked one that git does not ignore; ../shared is copied
# too where it exists. Packages are downloaded once, into ${XDG_CACHE_HOME:-~/.cache}/hpdm/packages.
# Exits with the command's status; 2 on wrong usage, 3 if root or mmdebstrap is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

root=
if [ "${1:-}" = --root ]; then
  root=${2:?--root needs a folder}
  shift 2
fi
if [ $# -eq 0 ]; then
  echo "usage: tools/fresh.sh [--root DIR] COMMAND [ARGUMENT...]" >&2
  exit 2
fi
if [ "$(id -u)" -ne 0 ]; then
  echo "fresh: run this as root: it mounts file systems" >&2
  exit 3
fi
if ! command -v mmdebstrap >/dev/null; then
  echo "fresh: mmdebstrap is missing; install it with apt-get install mmdebstrap" >&2
  exit 3
fi

packages=${XDG_CACHE_HOME:-$HOME/.cache}/hpdm/packages
mkdir -p "$packages"
if [ -z "$root" ]; then
  root=$(mktemp --directory --tmpdir hpdm-fresh.XXXXXX)
  trap 'rm -rf --one-file-system "$root"' EXIT
fi
mkdir -p "$root"
root=$(realpath "$root")

if [ ! -e "$root/etc/debian_version" ]; then
  echo "fresh: creating a root in $root"
  archives=var/cache/apt/archives
  # dpkg does not wait for the disk: a root left incomplete by a crash is created again anyway.
  if ! mmdebstrap --quiet --variant=minbase --include=git,ca-certificates \
    --setup-hook="mkdir -p \"\$1/$archives\"" \
    --setup-hook="find '$packages' -name '*.deb' -exec cp -t \"\$1/$archives\" {} +" \
    --setup-hook='mkdir -p "$1/etc/dpkg/dpkg.cfg.d"; echo force-unsafe-io >"$1/etc/dpkg/dpkg.cfg.d/fresh"' \
    --customize-hook="cp -n \"\$1/$archives\"/*.deb '$packages'" \
    bookworm "$root" >"$root.log" 2>&1; then
    tail -n 20 "$root.log" >&2
    echo "fresh: mmdebstrap failed; its output is in $root.log" >&2
    exit 1
  fi
  rm -f "$root.log"
  # An installed Debian has this file; Chromium's driver needs it to find localhost.
  printf '127.0.0.1 localhost\n::1 localhost\n' >"$root/etc/hosts"
fi

# Files keep their times, so that a second call builds only the changes.
checkout=$root/hpdm/checkout
mkdir -p "$checkout"
find "$checkout" -mindepth 1 -maxdepth 1 ! -name 'build*' ! -name out -exec rm -rf {} +
git ls-files --cached --others --exclude-standard -z |
  tar --create --null --files-from=- --ignore-failed-read 2>/dev/null |
  tar --extract --directory="$checkout"
if [ -d ../shared ]; then
  rm -rf "$root/hpdm/shared"
  cp --recursive --dereference --preserve=timestamps ../shared "$root/hpdm/shared"
fi

# The mounts are in a mount namespace of their own, which ends with the command and its processes. The
# root is bound onto itself because unshare --mount, which tests use, needs a mount point as its root.
kept=()
for name in CI TERM http_proxy https_proxy no_proxy; do
  if [ -n "${!name:-}" ]; then kept+=("$name=${!name}"); fi
done
enter='
  set -eu
  root=$1 packages=$2
  shift 2
  mount --bind "$root" "$root"
  mount --bind "$packages" "$root/var/cache/apt/archives"
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  mount --rbind /dev "$root/dev"
  cp -L /etc/resolv.conf "$root/etc/resolv.conf"
  cd "$root"
  exec chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 \
    PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    /bin/sh -c "cd /hpdm/checkout && exec /usr/bin/env \"\$@\"" sh "$@"'
unshare --mount --pid --fork --kill-child \
  bash -c "$enter" bash "$root" "$packages" "${kept[@]}" "$@"
