# 32-bit Arm: ARMv7-A with VFPv3-D16, hard-float (Debian's armhf).
set(SINEW_BOARD armhf)
set(SINEW_TRIPLET arm-linux-gnueabihf)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(SINEW_EMULATOR qemu-arm)
# Else the compiler notes at every use that some types are passed in another way than by gcc 6.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
include(${CMAKE_CURRENT_LIST_DIR}/board.cmake)
