#pragma once
#include <string>
#include <vector>

#include "fault.hpp"

namespace sinew::test {

/// docs/reference/device-faults.md: the cells of each device.
std::string page_of(const std::vector<std::vector<Cell>>& devices);
/// The table of one device within it.
std::string section_of(const std::vector<Cell>& cells);

}  // namespace sinew::test
