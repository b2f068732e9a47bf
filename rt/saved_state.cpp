#include "rt/saved_state.hpp"

#include <cstring>

#include "math/hash.hpp"
#include "rt/parameters.hpp"
#include "rt/segment.hpp"

namespace sinew::rt {

std::size_t SavedState::bytes() const noexcept {
  std::size_t sum = 0;
  for (const Declaration::Port& port : declaration_.ports) sum += port.input ? sizeof port.input->dropped_total_ : 0;
  for (const Declaration::State& state : declaration_.states) sum += state.bytes(state.member).size();
  return sum;
}

std::uint64_t SavedState::layout() const {
  math::Hash64 hash;
  const auto add = [&hash](std::string_view type, std::uint64_t size) {
    hash.add(type.data(), type.size());
    hash.add(&size, sizeof size);
  };
  for (const Declaration::Port& port : declaration_.ports)
    if (port.input) add(port.name, sizeof port.input->dropped_total_);
  for (const Declaration::State& state : declaration_.states) add(state.type, state.bytes(state.member).size());
  return hash.value();
}

void SavedState::save(std::span<std::byte> to) const noexcept {
  if (to.size() != bytes()) bug("room for a saved state has another size", "SavedState");
  std::byte* next = to.data();
  const auto put = [&next](const void* from, std::size_t size) {
    if (size != 0) std::memcpy(next, from, size);
    next += size;
  };
  for (const Declaration::Port& port : declaration_.ports)
    if (port.input) put(&port.input->dropped_total_, sizeof port.input->dropped_total_);
  for (const Declaration::State& state : declaration_.states) {
    const std::span<const std::byte> member = state.bytes(state.member);
    put(member.data(), member.size());
  }
}

hal::Status SavedState::restore(std::span<const std::byte> from) const {
  if (from.size() != bytes())
    return hal::Error{hal::Errc::bad_data, "a saved state of another size", static_cast<std::int64_t>(from.size())};
  std::vector<ParamValue> params;
  for (const Declaration::Param& p : declaration_.params) params.push_back(current(p));
  const std::byte* next = from.data();
  const auto get = [&next](void* to, std::size_t size) {
    if (size != 0) std::memcpy(to, next, size);
    next += size;
  };
  for (const Declaration::Port& port : declaration_.ports)
    if (port.input) get(&port.input->dropped_total_, sizeof port.input->dropped_total_);
  for (const Declaration::State& state : declaration_.states) {
    const std::span<std::byte> member = state.bytes(state.member);
    get(member.data(), member.size());
  }
  for (std::size_t i = 0; i < params.size(); ++i) assign(declaration_.params[i], params[i]);
  return {};
}

}  // namespace sinew::rt
