# Sourced: prints the stages of a script on standard error, one line each. The output of a stage is shown only if the stage
# fails; text written to the descriptor HYSTCAN_STAGE_STDERR is shown immediately.
# shellcheck shell=bash

# stage NAME COMMAND...: runs COMMAND and prints its wall time and processor time; on failure it prints the end of the log
# and ends the script.
stage() {
  local name=$1 log spent status=0
  shift
  log=$(mktemp -t hystcan-stage.XXXXXX)
  local TIMEFORMAT='%0R s, processor %0U s + %0S s'
  exec 3>&2
  export HYSTCAN_STAGE_STDERR=3
  spent=$({ time "$@" >"$log" 2>&1 </dev/null; } 2>&1) || status=$?
  exec 3>&-
  unset HYSTCAN_STAGE_STDERR
  if ((status)); then
    tail -n 40 "$log" >&2
    echo "$name: failed with status $status after $spent; the whole log: $log" >&2
    exit "$status"
  fi
  rm -f "$log"
  echo "$name: $spent" >&2
}

# configure_tree BUILD_TREE COMMAND...: runs the stage `configure`, with replacements for missing parts of the machine.
configure_tree() {
  local tree=$1
  shift
  skip_unwritable_ccache
  stage configure "$@"
  report_missing_page "$tree"
}

# skip_unwritable_ccache: compiles without ccache if a folder of it belongs to another user, as after a first run with sudo.
skip_unwritable_ccache() {
  local folder
  folder=$(ccache --get-config cache_dir 2>/dev/null) || return 0
  folder=$(unwritable_folder "$folder")
  [[ -n $folder ]] || return 0
  echo "ccache: $folder is not writable; compiling without it (mend: sudo chown -R $(id -un) $folder)" >&2
  export CCACHE_DISABLE=1
}

# unwritable_folder FOLDER: prints FOLDER if it has an unwritable folder, or the parent in which it cannot be created.
unwritable_folder() {
  local folder=$1
  if [[ -d $folder ]]; then
    [[ -z $(find "$folder" -maxdepth 2 -type d ! -writable -print -quit 2>/dev/null) ]] || echo "$folder"
    return
  fi
  until [[ -e $folder ]]; do folder=$(dirname "$folder"); done
  [[ -w $folder ]] || echo "$folder"
}

# report_missing_page BUILD_TREE: prints why the program is built without the operator's page, if so.
report_missing_page() {
  sed -n 's/^HYSTCAN_PAGE_MISSING:INTERNAL=\(..*\)/page: \1/p' "$1/CMakeCache.txt" >&2
}

# note_pass NAME: notes in build/release/passed/NAME that NAME has passed on this commit ("+": with changes), for
# scripts/release.
note_pass() {
  local commit
  commit=$(git rev-parse HEAD 2>/dev/null) || return 0
  [[ -z $(git status --porcelain) ]] || commit+=+
  mkdir -p build/release/passed
  echo "$commit $(date -u '+%F %R UTC')" >"build/release/passed/$1"
}
