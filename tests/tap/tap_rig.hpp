#pragma once
// A small robot of three modules in two threads, with its socket: in real time at ordinary priority, or in virtual
// time.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "hal/platform.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "tap/client.hpp"
#include "tap/server.hpp"
#include "tap_graph.hpp"

namespace sinew::tap {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;

/// This program's own run dir, removed at its end.
class OwnRunDir {
 public:
  OwnRunDir() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew-tap-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
    ::setenv("SINEW_RUN_DIR", path_.c_str(), 1);
  }
  ~OwnRunDir() { std::filesystem::remove_all(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

struct RobotOptions {
  std::string name = "robot";
  bool shared_memory = true;
  std::uint32_t first_sequence = 0xFFFFFF00;
  GraphOptions graph{};
  ServerOptions server{};
};

class Robot {
 public:
  explicit Robot(const RobotOptions& options = {})
      : options_(options), graph(robot_spec(options.graph), robot_types()) {
    for (const auto& p : graph.check({.virtual_time = true})) ADD_FAILURE() << rt::to_string(p, "robot");
    rt::ConfigureOptions configure;
    configure.os = options.shared_memory ? &os : nullptr;
    configure.first_sequence = options.first_sequence;
    if (!graph.configure(board_, configure)) ADD_FAILURE() << "configure";
  }
  ~Robot() {
    server.reset();
    if (real) real->stop();
  }

  void start() {
    rt::RealTimeOptions o;
    o.lock_memory = false;
    o.fixed_priority = options_.graph.priority > 0;
    real = std::make_unique<rt::RealTimeExecutor>(graph, os, o);
    ASSERT_TRUE(real->start());
    open(real->runner());
  }
  /// For a run of `duration` in virtual time.
  void prepare(rt::Duration duration, std::unique_ptr<hal::GrantSource> grants = nullptr) {
    grants_ = grants ? std::move(grants) : std::make_unique<hal::FixedGrant>(hal::Time{} + duration);
    rt::DiscreteOptions o;
    o.duration = duration;
    o.hash_topics = true;
    discrete = std::make_unique<rt::DiscreteExecutor>(graph, clock_, *grants_, o);
    open(discrete->runner());
  }
  void open(rt::Runner& runner) {
    std::string why;
    auto taken = Name::take(options_.name, why);
    ASSERT_TRUE(taken) << why;
    name = std::move(*taken);
    auto opened = Server::open(*name, graph, runner, os, options_.server);
    ASSERT_TRUE(opened) << opened.error().where;
    server = std::move(*opened);
  }
  std::unique_ptr<Client> client() {
    std::string why;
    auto c = Client::connect(options_.name, why);
    if (!c) ADD_FAILURE() << why;
    return c ? std::move(*c) : nullptr;
  }

 private:
  RobotOptions options_;

 public:
  hal::Os& os = hal::system_os();
  rt::Graph graph;
  std::unique_ptr<rt::RealTimeExecutor> real;
  std::unique_ptr<rt::DiscreteExecutor> discrete;
  std::unique_ptr<Name> name;
  std::unique_ptr<Server> server;

 private:
  hal::EmptyBoard board_;
  hal::ManualClock clock_;
  std::unique_ptr<hal::GrantSource> grants_;
};

inline Json ask(Client& client, std::string_view name, const Json& arguments = Json::object()) {
  const auto reply = client.request(name, arguments.is_object() ? arguments.dump() : "{}");
  if (!reply) return {{"failed", hal::to_string(reply.error().code)}};
  return Json::parse(*reply, nullptr, false);
}

}  // namespace sinew::tap
