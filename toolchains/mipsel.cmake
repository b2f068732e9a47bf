# 32-bit MIPS, little-endian: MIPS32 release 2 with a floating-point unit (Debian's mipsel).
set(SINEW_BOARD mipsel)
set(SINEW_TRIPLET mipsel-linux-gnu)
set(CMAKE_SYSTEM_PROCESSOR mipsel)
set(SINEW_EMULATOR qemu-mipsel)
# Its processors cannot read 64 bits at once, and the compiler's library for that takes locks. So no program links that
# library: a 64-bit atomic by mistake does not link. See hal/wide.hpp.
include(${CMAKE_CURRENT_LIST_DIR}/board.cmake)
