// Any requests to a running graph by its mailboxes: an accepted request takes effect once, in order, in the next cycle
// of its thread; a refused one gets a reason.
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>

#include "msg/operator.hpp"
#include "msg/sensors.hpp"
#include "rt/exec/discrete_executor.hpp"

namespace sinew::rt {
namespace {

using namespace std::chrono_literals;

constexpr Duration kLongestRun = 20ms;

void require(bool holds) {
  if (!holds) std::abort();
}

/// The fuzzer's bytes as decisions; zeros at their end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  template <class V>
  V take() {
    V v{};
    const std::size_t n = std::min(sizeof v, left_);
    std::memcpy(&v, data_, n);
    data_ += n, left_ -= n;
    return v;
  }
  std::uint32_t below(std::uint32_t n) { return take<std::uint8_t>() % n; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

class Tuned final : public Module {
 public:
  void declare(Declaration& d) override {
    d.param("gain", gain_, {.min = -1.0, .max = 2.0});
    d.param("count", count_, {.min = 1, .max = 9});
    d.param("fast", fast_);
    d.param("label", label_);
    d.out("out", out_);
  }
  StepStatus step(const Step& step) noexcept override {
    require(gain_ >= -1.0 && gain_ <= 2.0 && count_ >= 1 && count_ <= 9);
    msg::RangeSample& r = out_.loan();
    r.stamp = step.now;
    return StepStatus::ok;
  }

 private:
  double gain_ = 0;
  std::int64_t count_ = 1;
  bool fast_ = false;
  std::string label_;
  Out<msg::RangeSample> out_;
};

/// Compares what comes in with what was accepted. Nobody disables it.
class Keeper final : public Module {
 public:
  void declare(Declaration& d) override { d.in("link", in_, {.depth = 32}); }
  StepStatus step(const Step& step) noexcept override {
    require(in_.dropped() == 0);
    for (const msg::OperatorLink& link : in_) {
      require(!accepted.empty() && accepted.front() == link.sequence && link.stamp <= step.now);
      accepted.pop_front();
    }
    return StepStatus::ok;
  }
  std::deque<std::uint32_t> accepted;

 private:
  InQueue<msg::OperatorLink> in_;
};

class Commander final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    msg::ActuatorCommand& c = out_.loan();
    c.stamp = step.now;
    c.count = c.armed = 1;
    return StepStatus::ok;
  }

 private:
  Out<msg::ActuatorCommand> out_;
};

class Motors final : public hal::Actuators {
 public:
  hal::Status write(const msg::ActuatorCommand&, Duration) noexcept override { return {}; }
  hal::Status stop() noexcept override { return {}; }
};

class Board final : public hal::EmptyBoard {
 public:
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return &motors_; }

 private:
  Motors motors_;
};

GraphSpec spec() {
  GraphSpec g;
  const auto module = [&g](const char* name, const char* type) -> ModuleSpec& {
    g.modules.push_back({name, type, {}, {}, {ExecModel::Kind::constant, 10us, {}, 1.0}});
    return g.modules.back();
  };
  module("tuned", "Tuned");
  module("keeper", "Keeper").in["link"] = {"operator.link", 0};
  module("commander", "Commander");
  module("late", "Tuned");
  const auto thread = [&g](const char* name, int priority, std::initializer_list<const char*> order) -> ThreadSpec& {
    ThreadSpec& t = g.threads.emplace_back();
    t.name = name;
    t.priority = priority;
    for (const char* m : order) t.order.push_back({m, 0});
    return t;
  };
  thread("main", 20, {"tuned", "keeper"}).period = 100us;
  thread("control", 30, {"commander"}).period = 150us;
  ThreadSpec& late = thread("late", 10, {"late"});
  late.trigger = ThreadSpec::Trigger::topics;
  late.topics.push_back({"tuned.out", 0});
  g.topics.push_back({"operator.link", 0, 0, 0, ExternalSpec{"OperatorLink", "main"}});
  g.topics.push_back({"operator.baro", 0, 0, 0, ExternalSpec{"BaroSample", "main"}});
  g.actuators.push_back({"motors", {"commander.out", 0}, 1, 0, 1, 0, 1ms, ActuatorSpec::Safe::stop, 0});
  return g;
}

/// Posts the requests of the bytes between two grants, and checks the results.
class Poster final : public hal::GrantSource, public RunObserver {
 public:
  Poster(Bytes bytes, Graph& graph, Keeper& keeper)
      : bytes_(bytes), graph_(graph), keeper_(keeper), threads_(graph.threads().size()) {}

  hal::Result<Time> next_grant(Time done) override {
    now_ = done;
    while (!bytes_.empty()) {
      const std::uint32_t what = bytes_.below(10);
      if (what >= 8) break;
      act(what);
    }
    if (bytes_.empty() && ended_) return hal::Error{hal::Errc::closed, "end"};
    ended_ = bytes_.empty();  // one last grant, so that all periods but long ones come round
    return done + (ended_ ? 2ms : Duration{10'000} * (1 + bytes_.below(40)));
  }

  void completed(const StepRecord& r) noexcept override {
    const Thread& t = threads_[r.thread];
    const bool begins = graph_.threads()[r.thread].modules[0] == r.module;
    if (begins && r.now > t.last_post) require(t.taken == t.accepted.size());
  }
  void taken(const Request& request, const Effect& effect, Time now) noexcept override {
    Thread& t = threads_[request.thread];
    require(t.taken < t.accepted.size());
    const Accepted& expected = t.accepted[t.taken++];
    require(expected.kind == request.kind && now >= now_);
    (void)effect;
  }
  /// At the end: the tickets agree with the effects.
  void check_tickets() {
    for (const Thread& t : threads_)
      for (std::size_t i = t.accepted.size() > 60 ? t.accepted.size() - 60 : 0; i < t.accepted.size(); ++i)
        require(graph_.effect(t.accepted[i].ticket).has_value() == (i < t.taken));
  }

 private:
  struct Accepted {
    Request::Kind kind;
    Ticket ticket;
  };
  struct Thread {
    std::vector<Accepted> accepted;
    std::size_t taken = 0;
    Time last_post{-1};
  };

  std::string_view name(std::initializer_list<std::string_view> names) {
    return names.begin()[bytes_.below(static_cast<std::uint32_t>(names.size()))];
  }
  std::string_view module() { return name({"tuned", "late", "commander", "guardian", "operator", "", "nobody"}); }
  ParamValue value() {
    switch (bytes_.below(4)) {
      case 0:
        return bytes_.take<std::uint8_t>() % 2 == 0;
      case 1:
        return std::int64_t{bytes_.take<std::int8_t>()};
      case 2:
        return bytes_.take<double>();
      default:
        return std::string("text");
    }
  }

  void act(std::uint32_t what) {
    using K = Request::Kind;
    std::string why;
    switch (what) {
      case 0:
      case 1: {
        const auto m = module(), p = name({"gain", "count", "fast", "label", "none"});
        return note(K::set_param, graph_.set_param(m, p, value(), &why), why);
      }
      case 2: {
        const auto m = module();
        const bool on = bytes_.below(2) == 1;
        return note(on ? K::enable : K::disable, graph_.set_enabled(m, on, &why), why);
      }
      case 3: {
        const auto t = name({"main", "control", "late", "guardian", ""});
        const Duration period{bytes_.below(4) == 0 ? bytes_.take<std::int64_t>() : 1000 * bytes_.take<std::uint8_t>()};
        return note(K::set_period, graph_.set_period(t, period, &why), why);
      }
      case 4:
        return note(K::arm, graph_.arm(&why), why);
      case 5:
        return note(K::disarm, graph_.disarm(&why), why);
      default:
        return publish();
    }
  }

  void publish() {
    std::array<std::byte, 64> message{};
    for (int i = 0; i < 3; ++i) {
      const auto word = bytes_.take<std::uint32_t>();
      std::memcpy(message.data() + 8 + 4 * i, &word, sizeof word);
    }
    const auto topic = name({"operator.link", "operator.link", "operator.baro", "tuned.out", "nobody.x", ""});
    const auto known = graph_.find_topic(topic);
    const std::size_t right = known == kNone ? 0 : graph_.topics()[known].type->size;
    const std::size_t size = bytes_.below(4) == 0 ? bytes_.below(65) : std::min<std::size_t>(right, message.size());
    std::string why;
    const auto ticket = graph_.publish(topic, std::span(message).first(size), &why);
    note(Request::Kind::message, ticket, why);
    if (!ticket || topic != "operator.link") return;
    msg::OperatorLink link;
    std::memcpy(&link, message.data(), sizeof link);
    require(link.quality - link.quality == 0);
    keeper_.accepted.push_back(link.sequence);
  }

  void note(Request::Kind kind, const hal::Result<Ticket>& ticket, const std::string& why) {
    require(ticket.has_value() == why.empty());
    if (!ticket) return;
    Thread& t = threads_[ticket->thread];
    t.accepted.push_back({kind, *ticket});
    t.last_post = now_;
  }

  Bytes bytes_;
  Graph& graph_;
  Keeper& keeper_;
  std::vector<Thread> threads_;
  Time now_{};
  bool ended_ = false;
};

}  // namespace
}  // namespace sinew::rt

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::rt;
  if (size > 2000) return 0;
  ModuleTypes types;
  Keeper* keeper = nullptr;
  types.add<Tuned>("Tuned");
  types.add<Commander>("Commander");
  types.add("Keeper", [&keeper] {
    auto made = std::make_unique<Keeper>();
    keeper = made.get();
    return made;
  });
  Graph graph(spec(), types);
  require(graph.check({.virtual_time = true}).empty());
  Board board;
  require(graph.configure(board).has_value());
  Poster poster({data, size}, graph, *keeper);
  sinew::hal::ManualClock clock;
  DiscreteExecutor executor(graph, clock, poster, {.duration = kLongestRun, .observer = &poster});
  require(executor.run().has_value());
  poster.check_tickets();
  return 0;
}
