#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/result.hpp"
#include "rt/declaration.hpp"

namespace sinew::rt {

/// The state of one module between two steps: the members that it declared as state, and how many messages each of its
/// inputs has lost since the start. With it, the parameters and a record, the steps that follow can be executed again.
/// The bytes are those of the members: only a module with the same layout() understands them.
/// Thread:  the executor of the module, or any while the module stands still.
/// Owner:   the declaration outlives it.
class SavedState {
 public:
  explicit SavedState(const Declaration& declaration) : declaration_(declaration) {}
  /// Stays the same after configure().   RT: yes.
  std::size_t bytes() const noexcept;
  /// Hash over types and sizes of what is saved: keep it with the state, compare it before a restore. Configure only.
  std::uint64_t layout() const;
  /// `to` has bytes().   RT: yes.
  void save(std::span<std::byte> to) const noexcept;
  /// Leaves the parameters as they are, also those that lie inside of a declared member.
  /// Errors:  bad_data when `from` does not have bytes(): another version of the module, or other numbers of channels
  ///          or pixels. Nothing has changed then.
  hal::Status restore(std::span<const std::byte> from) const;

 private:
  const Declaration& declaration_;
};

}  // namespace sinew::rt
