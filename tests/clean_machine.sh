#!/usr/bin/env bash
# tests/clean_machine.sh [--test] [ROOT_DIR]
# The promise of the README on a bare Debian 12 that has git and nothing else: makes one with
# debootstrap (needs root), clones HEAD into it, and starts ./isolux there as a newcomer would.
# --test runs ./isolux test there too, with ../shared beside the clone where this checkout has one.
# A ROOT_DIR that is named stays afterwards; without one the root is made in /tmp and removed.
set -euo pipefail

repo=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)
with_tests=
if [[ ${1-} == --test ]]; then with_tests=1; shift; fi
root=${1-}
clone=/home/isolux-check/main  # inside the root

fail() { printf 'clean_machine: FAILED: %s\n' "$*" >&2; exit 1; }
[[ $EUID -eq 0 ]] || fail "needs root, for debootstrap and chroot"
command -v debootstrap >/dev/null || fail "debootstrap is not installed"
[[ ! $root || ! -e $root || ! $(ls -A -- "$root") ]] || fail "$root is not empty"

keep=$root
[[ $root ]] || root=$(mktemp -d /tmp/clean_machine.XXXXXX)
mkdir -p -- "$root"
chmod 755 -- "$root"  # mktemp makes it for root alone, but nobody starts the program too
root=$(cd -- "$root" && pwd -P)
mounted=()
clean_up() {
  local i
  for ((i = ${#mounted[@]} - 1; i >= 0; i--)); do umount -- "${mounted[i]}" || return; done
  if [[ ! $keep ]]; then rm -rf --one-file-system -- "$root"; fi
}
trap clean_up EXIT
trap 'exit 130' INT TERM

# timed WHAT COMMAND...: runs it, says how long it took, and leaves that in $took (milliseconds).
timed() {
  local what=$1 begin=${EPOCHREALTIME/[.,]/}
  shift
  "$@" || fail "$what (exit status $?)"
  took=$(((${EPOCHREALTIME/[.,]/} - begin) / 1000))
  printf 'clean_machine: %-34s %4d.%03d s\n' "$what" $((took / 1000)) $((took % 1000)) >&2
}

# inside [VAR=VALUE...] COMMAND...: in the root, in a bare environment, with no terminal.
inside() {
  env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
    chroot "$root" /usr/bin/env -C "$start_in" "$@" </dev/null
}
start_in=/

# Debian 12 from where this machine gets its own packages, set up the same way.
# shellcheck disable=SC2016  # apt's own placeholders
mirror=$(apt-get indextargets --format '$(RELEASE) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' |
  awk '$1 == "bookworm" && $2 == "main" { print $3; exit }')
[[ $mirror ]] || fail "apt here knows no source of Debian 12; add one, or run apt-get update"
include=git
[[ $mirror != https:* ]] || include=git,ca-certificates
bare_debian() {
  local log
  log=$(debootstrap --variant=minbase --include="$include" bookworm "$root" "$mirror" 2>&1) ||
    { tail -n 20 <<<"$log" >&2; return 1; }
}
timed "debootstrap (Debian 12 and git)" bare_debian
cp /etc/resolv.conf "$root/etc/resolv.conf"
apt-config dump --format '%F "%v";%n' | grep -E '^Acquire::(https?|Check-)' \
  >"$root/etc/apt/apt.conf.d/80host" || true
rm -rf -- "$root"/var/lib/apt/lists/* "$root"/var/cache/apt/*  # as slim images come

mount -t proc proc "$root/proc"
mounted+=("$root/proc")
git clone -q --no-hardlinks -- "$repo" "$root$clone"
if [[ -d $repo/../shared ]]; then
  mkdir "$root$clone/../shared"
  mount --bind -- "$repo/../shared" "$root$clone/../shared"
  mounted+=("$root$clone/../shared")
  mount -o remount,bind,ro -- "$root$clone/../shared"
fi
start_in=$clone

# refused WORD COMMAND...: exit status 1, nothing on standard output, WORD in the last line.
refused() {
  local word=$1 status=0 out
  shift
  out=$(inside "$@" 2>"$root/tmp/refused") || status=$?
  [[ $status == 1 && ! $out && $(tail -n 1 "$root/tmp/refused") == "isolux: error: "*"$word"* ]] ||
    { cat "$root/tmp/refused" >&2; fail "expected a refusal with '$word': $* (exit status $status)"; }
}
refused "apt-get install" ./isolux --help
chown -R nobody "$root$clone"
refused "administrator" setpriv --reuid=nobody --clear-groups env CI=true ./isolux --help
chown -R root "$root$clone"
echo "clean_machine: without consent, or without root, it says what to do"

timed "first ./isolux render" inside CI=true ./isolux render -o head.png
[[ $(head -c 4 "$root$clone/head.png" | tail -c 3) == PNG ]] || fail "head.png is no PNG"
[[ -s $root/root/.cache/isolux/Cranium.inv3 ]] || fail "the CT head is not in the cache folder"
mv -- "$root$clone/head.png" "$root$clone/first.png"
timed "second ./isolux render" inside ./isolux render -o head.png
cmp -- "$root$clone/first.png" "$root$clone/head.png" || fail "the second picture differs"
timed "./isolux --help" inside ./isolux --help >/dev/null
((took < 1000)) || fail "a start took $took ms; it must take well under a second"

# As anyone: from another folder, through a link, in a checkout that is not theirs.
ln -s "$clone/isolux" "$root/usr/local/bin/isolux"
start_in=/tmp
timed "as nobody, through a link" inside HOME=/tmp/nobody setpriv --reuid=nobody --clear-groups \
  isolux render -o nobody.png
[[ -s $root/tmp/nobody.png ]] || fail "no picture in the caller's folder"
start_in=$clone

if [[ $with_tests ]]; then timed "./isolux test" inside CI=true ./isolux test; fi
inside git status --porcelain | grep -v -e 'first.png' -e 'head.png' && fail "files git knows nothing of"
echo "clean_machine: passed"
