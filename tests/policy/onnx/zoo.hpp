#pragma once
// Networks that the tests make: each operator in the forms that exporters write, and whole policies.
#include <string>
#include <vector>

#include "../../../bench/networks.hpp"

namespace sinew::onnx::test {

struct ZooNetwork {
  std::string name;
  ModelWriter model;
};

std::vector<ZooNetwork> zoo();
/// Numbers for the inputs of a network, in order.
std::vector<std::vector<float>> inputs_for(const ZooNetwork& network);

}  // namespace sinew::onnx::test
