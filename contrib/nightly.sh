#!/usr/bin/env bash
# The nightly gate on a machine of the lab. Quiet when robots stand and walk as well as before;
# otherwise prints a page for each experiment that does not, and exits with the code of
# `gaitlab check`, so that cron sends a mail and systemd marks the service as failed.
#
#   nightly.sh FOLDER     FOLDER holds nightly.json and standing.json, the baselines; the store and
#                         the pages are written there
set -euo pipefail
cd "$1"
verdict=0

for experiment in ${EXPERIMENTS:-nightly standing}; do
  name=$(basename "$experiment" .yaml)
  rm -f tonight.md
  code=0
  gaitlab check "$experiment" --baseline "$name.json" --store store --summary tonight.md \
    >/dev/null 2>tonight.log || code=$?
  if [[ $code == 0 ]]; then
    continue
  fi
  if [[ $code != 6 || $verdict == 0 ]]; then  # that something is worse outweighs what is open
    verdict=$code
  fi
  case $code in
    5) echo "The robot walks worse." ;;
    6) echo "Nothing could be decided." ;;
    *) echo "The nightly run of $name ended with exit code $code:"; cat tonight.log ;;
  esac
  if [[ -f tonight.md ]]; then cat tonight.md; fi
  echo
  echo "Look closer: gaitlab report $experiment --store $PWD/store --format html"
done
exit "$verdict"
