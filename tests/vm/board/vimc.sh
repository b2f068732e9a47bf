modprobe vimc
ls -l /dev/video* /dev/media*
cat /sys/class/video4linux/*/name
