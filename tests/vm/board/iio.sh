# limit_s: 60
modprobe -a industrialio-triggered-buffer kfifo_buf industrialio-configfs industrialio-sw-device \
  industrialio-sw-trigger iio-trig-hrtimer iio_dummy
mkdir /sys/kernel/config/iio/triggers/hrtimer/hr0 /sys/kernel/config/iio/devices/dummy/dummy0
ls /sys/bus/iio/devices/ /dev/iio*
i2c_stub 0x68 0x69
$build/tests/vm/vm_i2c_registers $adapter 0x69 0x00=0xd1 0x12=0x34 0x13=0x12 0x03=0x15
modprobe bmi160_i2c
echo bmi160 0x69 >/sys/bus/i2c/devices/i2c-$adapter/new_device
eventually 5 iio_device bmi160
ls $device $device/scan_elements
cat $device/in_accel_x_raw
