# 64-bit Arm: ARMv8-A (Debian's arm64).
set(SINEW_BOARD arm64)
set(SINEW_TRIPLET aarch64-linux-gnu)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(SINEW_EMULATOR qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/board.cmake)
