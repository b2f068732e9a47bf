# limit_s: 60
# Our own MPU-6050 driver over the kernel's I2C: i2c-stub, whose registers do not change.
i2c_stub 0x68
$build/tests/vm/vm_i2c_registers "$adapter" 0x68 0x75=0x68 0x3a=0x01 0x3b=0x10 0x3c=0x20 # WHO_AM_I, data ready, x: 4128
SINEW_I2C=$adapter:0x68 SINEW_I2C_ACCEL_X_COUNTS=4128 gtest drivers/drivers_mpu6050_test --gtest_filter='Mpu6050Kernel.*'
modprobe -r i2c-stub
