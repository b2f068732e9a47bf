#pragma once
#include "hal/sample_ring.hpp"

namespace sinew::sim_hil {
using hal::SampleRing;
}
