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
export DISPLAY=:$number XDG_CONFIG_HOME=$folder/config

"$cairn" view "$pack" --camera="$camera" --size 320x240 2>messages &
viewer=$!
for _ in $(seq 300); do window=$(xdotool search --name '^cairn$' 2>/dev/null | head -1) && [ -n "$window" ] && break; sleep 0.1; done
[ -n "$window" ]
# Refused until it is on the screen.
for _ in $(seq 300); do xdotool windowfocus "$window" 2>/dev/null && break; sleep 0.1; done

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
# Minimised it draws nothing, and so saves nothing, but goes on.
# state NUMBER: what a window manager, which is not here, would write down: 3 minimised, 1 not (ICCCM 4.1.3.1).
state() {
  python3 - "$window" "$1" <<'PY'
import ctypes, sys
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
x.XInternAtom.argtypes, x.XInternAtom.restype = (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int), ctypes.c_ulong
x.XChangeProperty.argtypes = [ctypes.c_void_p] + 3 * [ctypes.c_ulong] + 2 * [ctypes.c_int] + [ctypes.c_void_p, ctypes.c_int]
x.XSync.argtypes = (ctypes.c_void_p, ctypes.c_int)
display = x.XOpenDisplay(None)
name = x.XInternAtom(display, b"WM_STATE", 0)
x.XChangeProperty(display, int(sys.argv[1]), name, name, 32, 0, (ctypes.c_long * 2)(int(sys.argv[2]), 0), 2)
x.XSync(display, 0)
PY
  sleep 1
}
if command -v python3 >/dev/null; then
  state 3
  press F12
  sleep 1
  [ ! -e cairn-$((pictures + 1)).png ]
  kill -0 $viewer
  state 1
fi
press F4; shot again.png
press w; shot ahead.png
xdotool keydown Escape; sleep 1; xdotool keyup Escape
for _ in $(seq 100); do kill -0 $viewer 2>/dev/null || break; sleep 0.1; done
wait $viewer
[ -s config/cairn/view.json ]
