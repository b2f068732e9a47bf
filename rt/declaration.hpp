#pragma once
// What a module declares: ports and parameters with unit, range and default.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <variant>
#include <vector>

#include "rt/padding.hpp"
#include "rt/port.hpp"

namespace sinew::rt {

enum class Overflow : std::uint8_t { drop_oldest, drop_newest };

struct InOptions {
  Duration max_age{INT64_MAX};  // for fresh()
  bool optional = false;        // may stay unbound
  bool previous = false;        // comes from a later module of the same thread: the message of the previous cycle
  bool supervises = false;      // decides whether to act, not how: no chain's origin goes on through it
};

struct QueueOptions {
  std::uint32_t depth = 8;
  Overflow overflow = Overflow::drop_oldest;
  bool optional = false;
  bool previous = false;
};

struct OutOptions {
  std::uint32_t burst = 1;     // loans in one step
  std::uint32_t channels = 0;  // an ActuatorCommand always has so many; 0: its parameters or inputs decide
  Duration usual_period{};     // written about once in this time, not in each step: history and rates follow it
};

struct RawOptions {
  std::uint32_t burst = 8;  // loans in one collect()
};

/// Numeric limits are inclusive. Without `max` anything finite from `min` up is allowed.
struct ParamOptions {
  std::string_view unit = "1";
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
  std::string_view doc = {};
};

using ParamValue = std::variant<bool, std::int64_t, double, std::string>;

/// The part of a number's declared range that the device allows in this run.
struct ParamRange {
  double min, max;                // inclusive; equal: nothing can be set here
  std::optional<double> besides;  // one more value, outside of the range: it leaves the device alone
  std::string because;            // what sets this range: "control 'gain' of device 'camera'"
};

/// Collects what declare() says. Names are [a-z0-9_]+ and unique within the module, ports and parameters apart.
/// Thread:  owner, before configure().
class Declaration {
 public:
  enum class PortKind : std::uint8_t { latest, queue, output, raw };
  struct Port {
    std::string name;
    PortKind kind;
    const msg::TypeInfo* type;  // null: an AnyIn or AnyOut that is not bound yet
    InputBase* input;           // latest, queue, raw
    OutputBase* output;         // output, raw
    std::uint32_t depth;        // queue, raw: messages; latest: 1
    std::uint32_t burst;        // output, raw
    Overflow overflow = Overflow::drop_oldest;
    Duration max_age{INT64_MAX};
    bool optional = false;
    bool previous = false;
    bool supervises = false;
    std::uint32_t channels = 0;   // output: OutOptions::channels
    Duration usual_period{};      // output: OutOptions::usual_period; 0: in each step
    Duration expires{INT64_MAX};  // latest: older messages are not there; set by the graph (ModuleSpec::max_age)

    bool is_input() const { return kind == PortKind::latest || kind == PortKind::queue; }
  };
  struct Param {
    std::string name;
    std::variant<bool*, std::int64_t*, double*, std::string*> target;
    ParamValue default_value;  // what the member held when declared
    std::string unit, doc;
    double min, max;  // numbers only
  };
  struct State {
    void* member;
    std::span<std::byte> (*bytes)(void* member) noexcept;  // as it is now
    const char* type;                                      // a name that two builds agree on
  };

  template <msg::Described M>
  void in(std::string_view name, In<M>& port, const InOptions& o = {}) {
    add_latest(name, &msg::type_info<M>(), port, o);
  }
  void in(std::string_view name, AnyIn& port, const InOptions& o = {}) { add_latest(name, nullptr, port, o); }
  template <msg::Described M>
  void in(std::string_view name, InQueue<M>& port, const QueueOptions& o = {}) {
    ports.push_back({std::string(name), PortKind::queue, &msg::type_info<M>(), &port, nullptr, o.depth, 0, o.overflow,
                     Duration{INT64_MAX}, o.optional, o.previous});
  }
  template <msg::Described M>
  void out(std::string_view name, Out<M>& port, const OutOptions& o = {}) {
    ports.push_back({std::string(name), PortKind::output, &msg::type_info<M>(), nullptr, &port, 0, o.burst});
    ports.back().channels = o.channels;
    ports.back().usual_period = o.usual_period;
  }
  void out(std::string_view name, AnyOut& port, const OutOptions& o = {}) {
    ports.push_back({std::string(name), PortKind::output, nullptr, nullptr, &port, 0, o.burst});
  }
  template <msg::Described M>
  void raw(std::string_view name, Raw<M>& port, const RawOptions& o = {}) {
    ports.push_back({std::string(name), PortKind::raw, &msg::type_info<M>(), &port, &port, o.burst, o.burst});
  }
  template <class V>
  void param(std::string_view name, V& target, const ParamOptions& o = {}) {
    params.push_back(
        {std::string(name), &target, ParamValue(target), std::string(o.unit), std::string(o.doc), o.min, o.max});
  }
  /// Members that a step leaves for later ones: trivially copyable, without pointers and padding (kHasNoPadding), or
  /// vectors of such whose size stays what configure() made it. A record with such a saved state can be executed again
  /// from that state, not only from its beginning. Parameters inside are no state: they stay as they are when the state
  /// is restored.
  template <class... M>
  void state(M&... members) {
    (states.push_back({&members, &state_bytes<M>, typeid(M).name()}), ...);
  }
  /// The module calls libraries that allocate or block (OpenCV): refused in real-time threads; the trap only counts.
  void best_effort() { is_best_effort = true; }

  std::vector<Port> ports;
  std::vector<Param> params;
  std::vector<State> states;
  bool is_best_effort = false;

 private:
  template <class T>
  static std::span<std::byte> plain_bytes(T* first, std::size_t count) noexcept {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>, "state is kept as its bytes");
    static_assert(
        kHasNoPadding<T>,
        "a state has no padding, and a constexpr constructor that shows it: put members of the same size side "
        "by side, and std::uint32_t for a single bool (rt/padding.hpp)");
    return std::as_writable_bytes(std::span(first, count));
  }
  template <class T>
  struct StateOf {
    static std::span<std::byte> bytes(T& member) noexcept { return plain_bytes(&member, 1); }
  };
  template <class T>
  struct StateOf<std::vector<T>> {
    static std::span<std::byte> bytes(std::vector<T>& all) noexcept { return plain_bytes(all.data(), all.size()); }
  };
  template <class M>
  static std::span<std::byte> state_bytes(void* member) noexcept {
    return StateOf<M>::bytes(*static_cast<M*>(member));
  }
  void add_latest(std::string_view name, const msg::TypeInfo* type, InputBase& port, const InOptions& o) {
    ports.push_back({std::string(name), PortKind::latest, type, &port, nullptr, 1, 0, Overflow::drop_oldest, o.max_age,
                     o.optional, o.previous, o.supervises});
  }
};

}  // namespace sinew::rt
