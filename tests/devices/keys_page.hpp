#pragma once
#include <string>
#include <vector>

#include "drivers/board/driver_list.hpp"

namespace sinew::test {

/// docs/reference/device-keys.md: all tables of keys.
std::string keys_page(const std::vector<drivers::KeyTable>& tables);

}  // namespace sinew::test
