# Sourced: runs apt-get as root while other package managers may be running, such as unattended-upgrades after boot.
# shellcheck shell=bash

# apt_get ARG...: runs apt-get, with HYSTCAN_SUDO (sudo) if this is not root; prints the end of its output only if it fails.
# If another process holds a lock (of the lists, the archives or dpkg), it reports that and tries 120 times, with
# HYSTCAN_APT_RETRY_S seconds (5) in between.
apt_get() {
  local log status=0 tries=0
  local -a sudo=()
  ((EUID == 0)) || read -ra sudo <<<"${HYSTCAN_SUDO:-sudo}"
  log=$(mktemp -t hystcan-apt.XXXXXX)
  while ! "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get "$@" >"$log" 2>&1; do
    if ((tries == 120)) || ! grep -qE '^E: (Could not get lock|Unable to (acquire the dpkg frontend )?lock)' "$log"; then
      tail -n 20 "$log" >&2
      status=1
      break
    fi
    ((tries++)) || report_lock "$log"
    sleep "${HYSTCAN_APT_RETRY_S:-5}"
  done
  rm -f "$log"
  return "$status"
}

# Prints the lock and its process at once, also within a stage (scripts/stages.sh).
report_lock() {
  local text
  text="packages: another package manager is at work; waiting for up to ten minutes: $(grep -m 1 '^E:' "$1")"
  echo "$text" >&"${HYSTCAN_STAGE_STDERR:-2}"
}
