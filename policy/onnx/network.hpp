#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "policy/onnx/model.hpp"
#include "policy/onnx/operations.hpp"

namespace sinew::onnx {

struct LoadedNetwork;

struct NetworkOptions {
  const Kernels* kernels = nullptr;  // null: best_kernels(); all give the same bits
};

/// A neural network out of an ONNX file, for one observation at a time. Numbers are float; the same file and the same
/// inputs give the same bits on every processor.
///
///   auto loaded = onnx::Network::load(bytes);
///   if (!loaded.network) return report(loaded.problems);
///   std::copy(observation.begin(), observation.end(), loaded.network->input(0).begin());
///   loaded.network->run();
///   use(loaded.network->output(0));
///
/// Shape:   a dimension without a number ("batch") counts as 1. All shapes are known once it is loaded.
/// Thread:  owner.   RT: input(), run(), output(): yes; load(): no.
class Network {
 public:
  struct Port {
    std::string name{};
    Dims dims{};
    Place place{};
    std::size_t size() const { return place.count; }
  };

  /// Takes time and memory in proportion to the file and to what one run needs, both bounded (kMost...).
  static LoadedNetwork load(Bytes file, const NetworkOptions& options = {});

  const std::vector<Port>& inputs() const { return inputs_; }
  const std::vector<Port>& outputs() const { return outputs_; }
  /// -1: no such.
  int find_input(std::string_view name) const { return find(inputs_, name); }
  int find_output(std::string_view name) const { return find(outputs_, name); }
  /// In row-major order; run() leaves them as they are.
  std::span<float> input(std::size_t i) { return {memory_.data() + inputs_[i].place.offset, inputs_[i].size()}; }
  std::span<const float> output(std::size_t i) const {
    return {memory_.data() + outputs_[i].place.offset, outputs_[i].size()};
  }
  /// Computes the outputs from the inputs alone: nothing is kept from one run to the next. NaN has one form
  /// (math::kNanF).
  void run() noexcept;

  std::size_t operations() const { return operations_.size(); }
  std::uint64_t multiplications() const { return multiplications_; }  // of weights in a run

 private:
  friend class Compiler;
  static int find(const std::vector<Port>& ports, std::string_view name);

  std::vector<Port> inputs_, outputs_;
  Operations operations_;
  AlignedFloats memory_;
  const Kernels* kernels_ = nullptr;
  std::uint64_t multiplications_ = 0;
};

struct LoadedNetwork {
  std::unique_ptr<Network> network{};   // null: it has problems
  std::vector<std::string> problems{};  // each names its node; not more than kMostProblems
};

inline constexpr std::size_t kMostProblems = 20;
inline constexpr std::size_t kMostMemory = 32 << 20;                  // numbers, of all values while loading
inline constexpr std::uint64_t kMostMultiplications = 1'000'000'000;  // of a run

/// Names of the operators, in the order of the alphabet, and the opsets.
std::vector<std::string> supported_operators();
inline constexpr std::int64_t kFirstOpset = 7, kLastOpset = 22;

}  // namespace sinew::onnx
