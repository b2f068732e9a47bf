# limit_s: 30
# only: arm64
# Edges of a GPIO line with the kernel's stamps. The machine's power button moves the line: the watchdog that nobody feeds
# presses it, for 100 ms of the guest's time, which in real time a loaded host would take from the guest.
[[ ! -e /sys/bus/platform/drivers/gpio-keys/gpio-keys ]] || echo gpio-keys >/sys/bus/platform/drivers/gpio-keys/unbind
while :; do # opened, it waits for two heartbeats and presses; that clears its settings, which only its driver's start makes
  modprobe i6300esb heartbeat=1
  eventually 10 test -e /dev/watchdog0
  exec {watchdog}>/dev/watchdog0
  sleep 4
  echo V >&$watchdog # it may be stopped
  exec {watchdog}>&-
  modprobe -r i6300esb
done &
presses=$!
trap 'kill $presses' EXIT
SINEW_GPIO_PULSED=/dev/gpiochip0:3 gtest hal/hal_linux_gpio_test --gtest_filter=*.Edges*
