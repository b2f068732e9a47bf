#include "apps/search/case_flight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include <nlohmann/json.hpp>

#include "apps/module_list.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/robot_file/world_report.hpp"
#include "apps/run/plant_process.hpp"
#include "apps/search/schedule_check.hpp"
#include "apps/search/watched_board.hpp"
#include "hal/platform.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/latch.hpp"
#include "sim_hil/board/sim_board.hpp"

namespace sinew::search {
namespace {

using namespace std::chrono_literals;
using msg::MissionPhase;

constexpr std::uint32_t kFirstSequence = 0xFFFFFF00;  // every run sees the numbers wrap
constexpr double kWall_m = 3.6;  // the walls of robots/quad/world/room.xml stand 4 m from the pad, arms are 0.3 m
constexpr rt::Duration kPatience = 60s;  // on a machine that is busy with other flights; a hang is ended from outside
constexpr rt::Duration kAtRest = 500ms;  // so that a lease that does not end, or a restart, is seen

/// The newest message of the first topic of type M.
template <msg::Described M>
class Tap {
 public:
  static std::uint32_t topic_of(const rt::Graph& graph) {
    for (std::uint32_t t = 0; t < graph.topics().size(); ++t)
      if (graph.topics()[t].type == &msg::type_info<M>()) return t;
    return rt::kNone;
  }
  static void add_to(std::vector<std::string>& taps, const rt::Graph& graph) {
    if (const std::uint32_t t = topic_of(graph); t != rt::kNone) taps.push_back(graph.topics()[t].name);
  }
  void open(rt::Graph& graph, std::size_t& next) {
    topic_ = topic_of(graph);
    if (topic_ == rt::kNone) return;
    latch_ = std::make_unique<rt::Latch>(graph.segment());
    latch_->bind(port_, graph.taps()[next++]);
  }
  /// Calls `use(message, sequence)` when there is one.
  template <class Use>
  void look(Use&& use) {
    if (!latch_) return;
    latch_->latch();
    if (const M* m = port_.get()) use(*m, port_.header(0)->sequence);
    latch_->release();
  }
  std::uint32_t topic() const { return topic_; }

 private:
  std::uint32_t topic_ = rt::kNone;
  std::unique_ptr<rt::Latch> latch_;
  rt::In<M> port_;
};

/// The largest age at which the writer of a topic still takes its inputs.
rt::Duration oldest_input(const rt::Graph& graph, const std::string& topic) {
  rt::Duration oldest{0};
  for (const auto& port : graph.modules()[graph.topics()[graph.find_topic(topic)].writer].declaration.ports)
    if (port.kind == rt::Declaration::PortKind::latest) oldest = std::max(oldest, port.max_age);
  return std::min<rt::Duration>(oldest, 1h);  // none declared: nothing is too old
}

/// Plant steps in which a motor ran on a command whose lease was over, as the plant counted them.
std::uint64_t stale_actuations(const std::string& report) {
  const auto j = nlohmann::json::parse(report, nullptr, false);
  return j.is_object() ? j.value("stale_actuations", std::uint64_t{0}) : 0;
}

class CaseFlight final : private rt::RunObserver, private hal::GrantSource {
 public:
  CaseFlight(const FlightSettings& settings, const Case& c) : settings_(settings), case_(c) {}

  bool open(std::string& why) {
    graph_ = std::make_unique<rt::Graph>(spec(), types_);
    if (const auto problems = graph_->check({true, 0}); !problems.empty()) {
      why = app::to_string(problems[0], settings_.robot);
      return false;
    }
    if (!connect(why)) return false;
    const auto& actuators = graph_->spec().actuators;
    if (!actuators.empty()) {
      commands_.emplace(actuators[0], oldest_input(*graph_, actuators[0].command.value), verdict_);
      writer_ = graph_->topics()[graph_->find_topic(actuators[0].command.value)].writer;
    }
    watched_ = std::make_unique<WatchedBoard>(*board_, clock_, actuators.empty() ? "" : actuators[0].name,
                                              commands_ ? &*commands_ : nullptr);
    schedule_ = std::make_unique<ScheduleCheck>(*graph_, verdict_);
    rt::ConfigureOptions configure;
    configure.first_sequence = kFirstSequence;
    Tap<msg::MissionState>::add_to(configure.taps, *graph_);
    Tap<msg::NavState>::add_to(configure.taps, *graph_);
    Tap<msg::GuardianState>::add_to(configure.taps, *graph_);
    if (const auto ready = graph_->configure(*watched_, configure); !ready) {
      why = graph_->configure_problems().empty() ? std::string(ready.error().where)
                                                 : app::to_string(graph_->configure_problems()[0], settings_.robot);
      return false;
    }
    std::size_t tap = 0;
    mission_.open(*graph_, tap);
    state_.open(*graph_, tap);
    guardian_.open(*graph_, tap);
    return true;
  }

  bool run(std::string& why) {
    rt::DiscreteOptions options;
    options.duration = settings_.limits.run;
    options.hash_topics = true;
    options.observer = this;
    options.os = &hal::system_os();
    hal::GrantSource& grants = *this;
    executor_ = std::make_unique<rt::DiscreteExecutor>(*graph_, clock_, grants, options);
    misses_.assign(graph_->chains().size(), 0);
    const auto report = executor_->run();
    if (!report) {
      why = report.error().where;
      return false;
    }
    ended_ = report->reached;
    board_->bye("the case is over");
    static_cast<void>(plant_->wait_for_end(3s));  // its result is in its report
    if (report->end == rt::DiscreteReport::End::source_failed ||
        report->end == rt::DiscreteReport::End::source_closed) {
      why = "the plant: " + board_->problem();
      return false;
    }
    return true;
  }

  Outcome judge() {
    const auto report = app::parse_report(report_);
    Outcome o;
    o.ended_s = msg::seconds(ended_);
    o.worst = flight_.worst();
    rt::Runner& runner = executor_->runner();
    math::Hash64 hash;
    for (std::uint32_t t = 0; t < graph_->topics().size(); ++t) {
      const std::uint64_t h = runner.topic_hash(t);
      hash.add(&h, sizeof h);
    }
    o.hash = hash.value();
    for (std::uint32_t c = 0; c < graph_->chains().size(); ++c)
      o.worst_age_ms[graph_->chains()[c].spec.name] = 1e3 * msg::seconds(runner.chain_stats(c).age.max());
    for (std::uint32_t m = 0; m < graph_->modules().size(); ++m) o.steps += runner.module_stats(m).steps.value();
    for (std::uint32_t t = 0; t < graph_->threads().size(); ++t) o.overruns += runner.thread_stats(t).overruns.value();
    o.commands = board_->stats().commands;
    if (report) {
      o.landing_error_m = report->number("landing_error_m");
      o.touchdown_speed_mps = report->number("touchdown_speed_mps");
    }
    o.ending = ending(report);
    judge_ending(o);
    o.violation = verdict_.first();
    return o;
  }

 private:
  rt::GraphSpec spec() const {
    rt::GraphSpec graph = settings_.robot.graph;
    graph.board = "sim";
    graph.seed = case_.jitter;
    if (settings_.measured) {
      graph.guardian.exec = {rt::ExecModel::Kind::measured, {}, {}, 1.0};
      for (auto& m : graph.modules) m.exec = graph.guardian.exec;
    } else if (!case_.nominal)
      settings_.profile.apply(graph, [this](const std::string& name) { return case_.stress_of(name); });
    return graph;
  }

  bool connect(std::string& why) {
    app::PlantRequest request;
    request.endpoint = "auto";
    request.seed = case_.world;
    request.camera_width = settings_.robot.sim.camera_width;
    request.camera_height = settings_.robot.sim.camera_height;
    app::SimTable world = settings_.robot.sim;
    world.options["gust_mps"] = case_.gust_mps;
    request.extra = app::world_arguments(world);
    for (const Fault& f : case_.faults) {
      request.extra.push_back("--fault");
      request.extra.push_back(search::to_string(f));
    }
    plant_ = app::PlantProcess::open(request, why);
    if (!plant_) return false;
    sim_hil::SimBoardOptions sim;
    sim.robot = graph_->spec().robot;
    sim.seed = case_.world;
    sim.clock = &clock_;
    sim.patience = kPatience;
    sim.on_report = [this](const std::string& json) { report_ = json; };
    sim.on_truth = [this](hal::Time at, const sim_hil::Truth& truth) {
      flight_.truth(at, truth, commands_ ? commands_->valid_until() : at);
      contact_ = truth.contact != 0;
      at_wall_ |= std::max(std::fabs(truth.p_world_m.x), std::fabs(truth.p_world_m.y)) > kWall_m;
    };
    auto board = sim_hil::SimBoard::open(plant_->take_stream(), sim, why);
    if (!board) {
      why = plant_->with_its_end(why);
      return false;
    }
    board_ = std::move(*board);
    return true;
  }

  // ---- while it flies

  void completed(const rt::StepRecord& record) noexcept override {
    schedule_->completed(record);
    if (settings_.measured) (*settings_.measured)[graph_->modules()[record.module].spec.name].push_back(record.exec);
    if (!commands_ || record.module != writer_ || record.status != rt::StepStatus::ok) return;
    commands_->committed(record.now, record.completed);
    std::int64_t newest = graph_->chains().empty() ? INT64_MAX : INT64_MIN;
    for (const auto& chain : graph_->chains())
      newest = std::max(newest, executor_->runner().topic_stats(chain.from).last_stamp_ns.value());
    commands_->measured(msg::Time{newest});
  }

  hal::Result<hal::Time> next_grant(hal::Time done) override {
    if (runs_) look(done);  // at the first call nothing has run yet
    runs_ = true;
    if (verdict_.failed() || over(done)) executor_->request_stop();
    return board_->next_grant(done);
  }

  void look(hal::Time now) {
    rt::Runner& runner = executor_->runner();
    schedule_->look(now, runner);
    mission_.look([&](const msg::MissionState& m, std::uint32_t sequence) {
      phase_ = m.phase;
      check_sequence(now, mission_.topic(), sequence);
    });
    state_.look([&](const msg::NavState& s, std::uint32_t sequence) {
      flight_.estimate(s);
      check_sequence(now, state_.topic(), sequence);
    });
    guardian_.look([&](const msg::GuardianState& s, std::uint32_t sequence) {
      flight_.guardian(now, s.faults);
      check_sequence(now, guardian_.topic(), sequence);
    });
    check_ages(now, runner);
  }

  void check_sequence(hal::Time now, std::uint32_t topic, std::uint32_t newest) {
    const std::uint64_t messages = executor_->runner().topic_stats(topic).messages.value();
    if (newest != static_cast<std::uint32_t>(kFirstSequence - 1 + messages))
      verdict_.fail(
          "sequence", now,
          fmt::format("{}: number {} is the newest of {} messages", graph_->topics()[topic].name, newest, messages));
  }

  void check_ages(hal::Time now, rt::Runner& runner) {
    // While no command acts the guardian still reports ages of old commands. In a millisecond in which commands begin
    // to act again it is not known in which part the budget was missed.
    const bool acts = !commands_ || commands_->valid_until() > now, all_along = acts && acted_;
    acted_ = acts;
    for (std::uint32_t c = 0; c < misses_.size(); ++c) {
      const std::uint64_t misses = runner.chain_stats(c).budget_misses.value();
      if (misses == misses_[c]) continue;
      misses_[c] = misses;
      if (!all_along || flight_.failsafe_acted() || case_.disturbed(now, settings_.limits.recovery)) continue;
      const auto& chain = graph_->chains()[c].spec;
      verdict_.fail("age", now,
                    fmt::format("chain {}: older than its budget of {:.3f} ms, {:.3f} ms at worst", chain.name,
                                1e3 * msg::seconds(chain.budget), 1e3 * msg::seconds(runner.chain_stats(c).age.max())));
    }
  }

  /// On the ground with the motors out, for long enough.
  bool over(hal::Time now) {
    const bool stopped = !commands_ || commands_->valid_until() <= now;
    const bool ended = phase_ == MissionPhase::done || flight_.flew();
    if (!ended || !contact_ || !stopped) rest_since_ = now;
    return now - rest_since_ >= kAtRest;
  }

  // ---- afterwards

  Ending ending(const std::optional<app::WorldReport>& report) const {
    const bool stopped = !commands_ || commands_->valid_until() <= ended_;
    if (flight_.fell()) return Ending::fell;
    if (report && report->number("crashed") != 0) return at_wall_ ? Ending::at_the_wall : Ending::crashed;
    if (!flight_.flew()) return contact_ && stopped ? Ending::did_not_fly : Ending::not_over;
    if (!report || report->number("touched_down") == 0 || !contact_ || !stopped) return Ending::not_over;
    const bool good = report->verdict && report->verdict->good;
    return phase_ == MissionPhase::done && good ? Ending::landed_on_pad : Ending::landed_elsewhere;
  }

  void judge_ending(const Outcome& o) {
    if (const std::uint64_t n = stale_actuations(report_))
      verdict_.fail("lease", ended_,
                    fmt::format("the plant ran the motors for {} steps on commands that were over", n));
    if (verdict_.failed()) return;
    const bool fine = o.ending == Ending::landed_on_pad || (o.ending == Ending::fell && excused_.failsafe) ||
                      (o.ending == Ending::crashed && excused_.failsafe) ||
                      (o.ending == Ending::landed_elsewhere && excused_.elsewhere) ||
                      (o.ending == Ending::at_the_wall && excused_.elsewhere) ||
                      (o.ending == Ending::did_not_fly && excused_.elsewhere);
    if (fine) return;
    if (o.ending == Ending::not_over)
      return verdict_.fail(
          "end", ended_,
          fmt::format("the flight is not over after {:.0f} s, in phase {}", o.ended_s, static_cast<int>(phase_)));
    verdict_.fail("landing", ended_,
                  fmt::format("{}: {:.3f} m from the pad, touchdown with {:.2f} m/s", to_string(o.ending),
                              o.landing_error_m, o.touchdown_speed_mps));
  }

  const FlightSettings& settings_;
  const Case& case_;
  Verdict verdict_;
  const Excuses excused_ = excuses(case_, settings_.robot.graph.failsafes);
  FlightCheck flight_{case_, excused_, settings_.limits, verdict_};
  rt::ModuleTypes types_ = app::all_modules();
  std::unique_ptr<rt::Graph> graph_;
  hal::ManualClock clock_;
  std::unique_ptr<app::PlantProcess> plant_;
  std::unique_ptr<sim_hil::SimBoard> board_;
  std::unique_ptr<WatchedBoard> watched_;
  std::optional<CommandCheck> commands_;
  std::unique_ptr<ScheduleCheck> schedule_;
  std::unique_ptr<rt::DiscreteExecutor> executor_;
  Tap<msg::MissionState> mission_;
  Tap<msg::NavState> state_;
  Tap<msg::GuardianState> guardian_;
  std::uint32_t writer_ = rt::kNone;
  std::vector<std::uint64_t> misses_;  // per chain
  MissionPhase phase_ = MissionPhase::wait;
  bool runs_ = false, contact_ = true, at_wall_ = false, acted_ = false;
  hal::Time rest_since_, ended_;
  std::string report_;
};

}  // namespace

const char* to_string(Ending ending) {
  constexpr const char* kNames[] = {"landed on the pad", "landed elsewhere",         "came down at the wall",
                                    "did not fly",       "fell with stopped motors", "crashed",
                                    "not over"};
  return kNames[static_cast<std::size_t>(ending)];
}

std::optional<Outcome> fly(const FlightSettings& settings, const Case& c, std::string& why) {
  CaseFlight flight(settings, c);
  if (!flight.open(why) || !flight.run(why)) return std::nullopt;
  return flight.judge();
}

}  // namespace sinew::search
