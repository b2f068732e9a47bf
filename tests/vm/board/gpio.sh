# only: arm64
# Lines of a GPIO chip through the kernel's character device: the machine's PL061, whose line 3 the kernel's driver of the
# power button holds; the others are unconnected and keep their settings. amd64's machine has no such chip.
modprobe gpio_keys
eventually 10 test -e /sys/bus/platform/drivers/gpio-keys/gpio-keys
SINEW_GPIO=/dev/gpiochip0:5 SINEW_GPIO_HELD=/dev/gpiochip0:3 gtest hal/hal_linux_gpio_test --gtest_filter=-*.Edges*
