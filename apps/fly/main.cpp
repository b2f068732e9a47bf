// sinew-fly: runs a robot file against a simulator in lockstep, without recorder, socket or watching parent. The
// smallest program for a whole robot: for systems without `sinew`, and for comparing bytes.
#include <charconv>
#include <cstdio>
#include <limits>
#include <string>
#include <string_view>

#include "apps/flight/mission_watch.hpp"
#include "apps/flight/robot_modules.hpp"
#include "apps/flight/verdict.hpp"
#include "apps/flight/watched_grants.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "apps/robot_file/world_report.hpp"
#include "hal/platform.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "sim_hil/board/sim_board.hpp"

namespace {

using namespace sinew;
using namespace std::chrono_literals;

constexpr const char* kUsage =
    "usage: sinew-fly ROBOT.toml ENDPOINT [--seed N] [--duration SECONDS]\n"
    "  ROBOT.toml   what runs, e.g. robots/quad/quad.toml\n"
    "  ENDPOINT     of a simulator in lockstep, tcp:HOST:PORT: sinew-sim --listen tcp:0.0.0.0:4560 --lockstep\n"
    "Prints a hash of all bytes of each topic. 0: landed well; 1: not, or the simulator failed; 2: could not begin.\n";

constexpr double kMostSeconds = 366 * 86400;

struct Options {
  std::string robot, endpoint;
  std::uint64_t seed = 0;
  bool has_seed = false;
  double duration_s = 0;  // 0: until the mission has ended
};

int fail(int code, const std::string& what) {
  std::fprintf(stderr, "sinew-fly: %s\n", what.c_str());
  return code;
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc() && read.ptr == end && number >= 0 && number <= std::numeric_limits<Number>::max();
}

/// The reason, empty when all was understood.
std::string read_options(int count, char** words, Options& o) {
  for (int i = 1; i < count; ++i) {
    const std::string_view word = words[i];
    if (!word.starts_with("--")) {
      if (!o.endpoint.empty()) return std::string(word) + ": a third word";
      (o.robot.empty() ? o.robot : o.endpoint) = word;
      continue;
    }
    if (word != "--seed" && word != "--duration") return std::string(word) + ": unknown; there are --seed, --duration";
    const std::string_view value = ++i < count ? words[i] : "";
    o.has_seed = o.has_seed || word == "--seed";
    if (!(word == "--seed" ? read_number(value, o.seed) : read_number(value, o.duration_s)))
      return std::string(word) + " " + std::string(value) + ": a number, not below 0";
    if (o.duration_s > kMostSeconds) return std::string(word) + " " + std::string(value) + ": at most a year";
  }
  return o.endpoint.empty() ? "a robot file and an endpoint are needed" : "";
}

bool print(const std::vector<rt::Problem>& problems, const app::RobotFile& robot) {
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", app::to_string(p, robot).c_str());
  return !problems.empty();
}

int tell(const std::string& json, app::MissionWatch& mission) {
  const auto report = app::parse_report(json);
  if (!report) return fail(1, "the simulator sent no report");
  if (!report->valid) return fail(1, "invalid run: " + report->reason);
  const app::RunVerdict verdict = app::judge(*report, mission);
  if (report->verdict)
    for (const auto& m : report->verdict->measures) std::printf("%-19s %s\n", m.label.c_str(), to_string(m).c_str());
  if (!verdict.outcome.empty()) std::printf("%s\n", verdict.outcome.c_str());
  return verdict.good ? 0 : 1;
}

/// The first board of this robot that is not the simulator's, as a problem; empty: there is none.
std::string other_board(const rt::GraphSpec& robot) {
  constexpr const char* kOnlySim = "\": this program has the simulator's only (\"sim\")";
  if (robot.board != "sim") return "robot.board: \"" + robot.board + kOnlySim;
  for (const auto& [device, board] : robot.device_boards)
    if (board.value != "sim") return "robot.device_boards." + device + ": \"" + board.value + kOnlySim;
  return "";
}

int fly(const Options& options) {
  const rt::ModuleTypes types = app::robot_modules();
  app::LoadedRobot loaded = app::load_robot(options.robot);
  if (print(loaded.problems, loaded.robot)) return 2;
  if (const std::string why = other_board(loaded.robot.graph); !why.empty()) return fail(2, options.robot + ": " + why);
  if (options.has_seed) loaded.robot.graph.seed = options.seed;
  rt::Graph graph(loaded.robot.graph, types);
  if (print(graph.check({.virtual_time = true}), loaded.robot)) return 2;

  auto stream = hal::connect_stream(options.endpoint, 10s);
  if (!stream)
    return fail(2, options.endpoint + ": " + stream.error().where + " (" + to_string(stream.error().code) + ")");
  hal::Os& os = hal::system_os();
  hal::ManualClock clock;
  std::string why, report;
  sim_hil::SimBoardOptions sim;
  sim.robot = graph.spec().robot;
  sim.seed = loaded.robot.sim.seed.value_or(graph.spec().seed);
  sim.clock = &clock;
  sim.os = &os;
  sim.patience = 60s;  // virtual time has no deadline
  sim.on_report = [&](const std::string& json) { report = json; };
  auto board = sim_hil::SimBoard::open(std::move(*stream), sim, why);
  if (!board) return fail(2, why);
  rt::ConfigureOptions how;
  how.os = &os;
  how.taps = app::MissionWatch::taps(graph);
  const auto ready = graph.configure(**board, how);
  if (print(graph.configure_problems(), loaded.robot) || !ready)
    return fail(2, ready ? (*board)->problem() : ready.error().where);

  const auto first = (*board)->begin();
  if (!first) return fail(2, (*board)->problem());
  app::MissionWatch mission(graph);
  app::FlightEnd end(mission);
  app::WatchedGrants grants(**board, [&](hal::Time done) { return end.reached(done, report); });
  rt::DiscreteOptions discrete;
  discrete.start = *first;
  if (options.duration_s > 0) discrete.duration = rt::Duration{static_cast<std::int64_t>(options.duration_s * 1e9)};
  discrete.os = &os;
  discrete.hash_topics = true;
  rt::DiscreteExecutor executor(graph, clock, grants, discrete);
  grants.executor = &executor;
  const hal::Time begin = os.now();
  const auto ran = executor.run();
  if (!ran) return fail(2, ran.error().where);
  const double wall_s = msg::seconds(os.now() - begin);
  (*board)->bye("the flight is over");
  if (ran->end == rt::DiscreteReport::End::source_failed)
    return fail(1, "the simulator failed: " + (*board)->problem());
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t)
    std::printf("hash %-24s %016llx\n", graph.topics()[t].name.c_str(),
                static_cast<unsigned long long>(executor.runner().topic_hash(t)));
  std::printf("virtual time        %.1f s in %.1f s\n", msg::seconds(ran->reached - *first), wall_s);
  return tell(report, mission);
}

}  // namespace

int main(int count, char** words) {
  Options options;
  if (count == 2 && std::string_view(words[1]) == "--help") {
    std::fputs(kUsage, stdout);
    return 0;
  }
  const std::string why = read_options(count, words, options);
  if (why.empty()) return fly(options);
  std::fprintf(stderr, "sinew-fly: %s\n%s", why.c_str(), kUsage);
  return 2;
}
