# limit_s: 90
# IioImu on the kernel's bmi160 driver: polled without a trigger, buffered by a timer's trigger, then polled by choice. The chip
# is i2c-stub: its registers do not change.
modprobe -a industrialio-triggered-buffer kfifo_buf industrialio-sw-trigger iio-trig-hrtimer
mkdir /sys/kernel/config/iio/triggers/hrtimer/hr0
i2c_stub 0x69
$build/tests/vm/vm_i2c_registers "$adapter" 0x69 0x00=0xd1 0x03=0x15 0x12=0x34 0x13=0x12 \
  0x40=0x28 0x41=0x03 0x42=0x28 0x43=0x00 # 100 Hz, 2 g and 2000 deg/s, as after a reset
modprobe bmi160_i2c
echo bmi160 0x69 >"/sys/bus/i2c/devices/i2c-$adapter/new_device"
eventually 10 iio_device bmi160
grep -q 4660 "$device/in_accel_x_raw" || fail "the driver does not read the chip"

SINEW_IIO=bmi160 SINEW_IIO_NO_TRIGGER=1 SINEW_IIO_RATE=100 gtest hal/hal_linux_iio_test --gtest_filter='IioKernel.*'
SINEW_IIO=bmi160 SINEW_IIO_TRIGGER=hr0 SINEW_IIO_RATE=200 gtest hal/hal_linux_iio_test --gtest_filter='IioKernel.*'
SINEW_IIO=bmi160 SINEW_IIO_POLL=1 SINEW_IIO_RATE=100 gtest hal/hal_linux_iio_test --gtest_filter='IioKernel.*'
