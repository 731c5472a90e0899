#!/bin/sh
# Installs what is missing to build and run on Debian 12. Sourced by demo.sh and test.sh.
set -eu

WHEATSTONE_PACKAGES="ca-certificates g++ cmake ninja-build ccache pkg-config
 libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
 libopencv-calib3d-dev libopencv-contrib-dev libceres-dev libopenexr-dev
 libraw-dev libembree-dev libtbb-dev
 libfmt-dev libspdlog-dev nlohmann-json3-dev libcli11-dev libtomlplusplus-dev
 libglm-dev libssl-dev libepoxy-dev libegl-dev libegl1 libegl-mesa0 libgl1-mesa-dri
 libgtest-dev libgmock-dev libbenchmark-dev glslang-tools
 libhidapi-dev libhidapi-hidraw0 libusb-1.0-0-dev libgphoto2-dev libxcb-randr0-dev
 libumockdev-dev umockdev v4l-utils usbrelay gphoto2 usbutils xvfb"

missing=""
for package in $WHEATSTONE_PACKAGES; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
if [ -n "$missing" ]; then
  echo "Installing:$missing"
  as_root=""
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || { echo "run as root, or install sudo" >&2; exit 1; }
    as_root=sudo
  fi
  $as_root apt-get update -q
  # shellcheck disable=SC2086
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends $missing
fi
