# limit_s: 120
# SocketCanBus on the kernel's CAN: virtual buses with FD, error frames, filters, interfaces that go and come back.
can_up
SINEW_CAN=vcan0,vcan1 gtest hal/hal_linux_socket_can_test --gtest_filter='SocketCan.*'
