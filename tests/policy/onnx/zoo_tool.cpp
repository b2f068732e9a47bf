// Writes every network of the zoo and what Sinew makes of it, for other runtimes: NAME.onnx, and NAME.json with the
// inputs and outputs. usage: policy_onnx_zoo FOLDER; with -c in place of FOLDER: the corpus of the fuzzer, small
// networks only.
#include <cstdio>
#include <fstream>

#include "policy/onnx/network.hpp"
#include "zoo.hpp"

using namespace sinew::onnx;

namespace {

std::string json_of(std::span<const float> numbers) {
  std::string text = "[";
  char one[32];
  for (const float x : numbers) {
    std::snprintf(one, sizeof one, "%s%.9g", text.size() > 1 ? "," : "", double{x});
    text += one;
  }
  return text + "]";
}
std::string json_of(const Dims& dims) {
  std::string text = "[";
  for (const auto d : dims) text += (text.size() > 1 ? "," : "") + std::to_string(d);
  return text + "]";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const bool corpus = argc == 3 && std::string(argv[1]) == "-c";
  const std::string folder = argv[argc - 1];
  for (const auto& one : test::zoo()) {
    const std::string bytes = one.model.bytes();
    if (corpus && bytes.size() > 4000) continue;
    std::ofstream(folder + "/" + one.name + (corpus ? "" : ".onnx"), std::ios::binary) << bytes;
    if (corpus) continue;
    auto loaded = Network::load({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!loaded.network) {
      std::fprintf(stderr, "%s: %s\n", one.name.c_str(), loaded.problems.front().c_str());
      return 1;
    }
    const auto inputs = test::inputs_for(one);
    std::string text;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      std::copy(inputs[i].begin(), inputs[i].end(), loaded.network->input(i).begin());
      const Network::Port& port = loaded.network->inputs()[i];
      text += (i ? "," : "") +
              ("\"" + port.name + "\":{\"dims\":" + json_of(port.dims) + ",\"data\":" + json_of(inputs[i]) + "}");
    }
    loaded.network->run();
    text = "{\"inputs\":{" + text + "},\"outputs\":{";
    for (std::size_t o = 0; o < loaded.network->outputs().size(); ++o) {
      const Network::Port& port = loaded.network->outputs()[o];
      text += (o ? "," : "") + ("\"" + port.name + "\":{\"dims\":" + json_of(port.dims) +
                                ",\"data\":" + json_of(loaded.network->output(o)) + "}");
    }
    std::ofstream(folder + "/" + one.name + ".json") << text << "}}\n";
  }
  return 0;
}
