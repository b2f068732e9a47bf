#pragma once
#include <cstdint>

namespace sinew::motion {

enum class KickWay : std::uint8_t {
  forward,
  outward,  // to the kicking foot's own side
};

}  // namespace sinew::motion
