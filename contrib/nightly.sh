#!/usr/bin/env bash
# The nightly gate on a machine of the lab. Quiet when the robot walks as well as before; otherwise
# prints one page and exits with the code of `gaitlab check`, so that cron sends a mail and systemd
# marks the service as failed.
#
#   nightly.sh FOLDER     FOLDER holds nightly.json; the store and the page are written there
set -euo pipefail
cd "$1"
experiment=${EXPERIMENT:-nightly}

rm -f tonight.md
verdict=0
gaitlab check "$experiment" --baseline nightly.json --store store --summary tonight.md \
  >/dev/null 2>tonight.log || verdict=$?
if [[ $verdict == 0 ]]; then
  exit 0
fi
case $verdict in
  5) echo "The robot walks worse." ;;
  6) echo "Nothing could be decided." ;;
  *) echo "The nightly run ended with exit code $verdict:"; cat tonight.log ;;
esac
if [[ -f tonight.md ]]; then cat tonight.md; fi
echo
echo "Look closer: gaitlab report $experiment --store $PWD/store --format html"
exit "$verdict"
