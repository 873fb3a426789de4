# Sourced: the stages of a script, one line each on standard error; their output only where they fail.
# shellcheck shell=bash

# stage NAME COMMAND...: runs COMMAND, tells its wall time; on failure shows the log's tail and ends the script.
stage() {
  local name=$1 log status=0 begin=$SECONDS
  shift
  log=$(mktemp -t hystcan-stage.XXXXXX)
  "$@" >"$log" 2>&1 </dev/null || status=$?
  if ((status)); then
    tail -n 40 "$log" >&2
    echo "$name: failed with status $status after $((SECONDS - begin)) s; the whole log: $log" >&2
    exit "$status"
  fi
  rm -f "$log"
  echo "$name: $((SECONDS - begin)) s" >&2
}
