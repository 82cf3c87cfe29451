#!/usr/bin/env bash
# Opens a window of cairn view on a display of its own, presses keys, leaves pictures in FOLDER, beside headless.png:
# window_session.sh CAIRN PACK FOLDER CAMERA. Exits 77 where Xvfb or xdotool are missing.
set -euo pipefail
command -v Xvfb >/dev/null && command -v xdotool >/dev/null || exit 77
cairn=$1 pack=$2 folder=$3 camera=$4
cd "$folder"

mkfifo display-number
Xvfb -displayfd 3 -screen 0 500x400x24 -nolisten tcp 3>display-number 2>/dev/null &
server=$!
trap 'kill $server 2>/dev/null || true' EXIT
read -r number <display-number
export DISPLAY=:$number

"$cairn" view "$pack" --camera="$camera" --size 320x240 2>messages &
viewer=$!
for _ in $(seq 300); do window=$(xdotool search --name '^cairn$' 2>/dev/null | head -1) && [ -n "$window" ] && break; sleep 0.1; done
[ -n "$window" ]
xdotool windowfocus "$window"

press() { xdotool keydown "$1"; sleep 0.3; xdotool keyup "$1"; sleep 0.3; }

# shot NAME: presses F12 and waits for the picture.
pictures=0
shot() {
  pictures=$((pictures + 1))
  press F12
  for _ in $(seq 300); do [ -s cairn-$pictures.png ] && break; sleep 0.1; done
  sleep 0.2
  mv cairn-$pictures.png "$1"
}
# Until all tiles are there; a test on a busy machine has to wait.
for _ in $(seq 60); do shot first.png; cmp -s first.png headless.png && break; done
press F4; shot wireframe.png
xdotool windowsize "$window" 1 1; sleep 1
xdotool windowsize "$window" 320 240; sleep 1
press F4; shot again.png
press w; shot ahead.png
xdotool keydown Escape; sleep 1; xdotool keyup Escape
for _ in $(seq 100); do kill -0 $viewer 2>/dev/null || break; sleep 0.1; done
wait $viewer
