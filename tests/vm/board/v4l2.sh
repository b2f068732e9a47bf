modprobe vivid n_devs=1 node_types=0x1
ls -l /dev/video*
cat /sys/class/video4linux/*/name
