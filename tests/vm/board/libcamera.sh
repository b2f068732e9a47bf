# limit_s: 150
# LibcameraCamera on vimc, a camera with the parts of a phone's. libcamera takes only devices that udev knows, and no
# udev runs here.
modprobe vimc
mkdir -p /run/udev/data
for device in /sys/class/video4linux/*/dev /sys/bus/media/devices/*/dev; do
  echo "I:1" >"/run/udev/data/c$(cat "$device")"
done
SINEW_LIBCAMERA=1 gtest hal/hal_libcamera_test
modprobe -r vimc
